// The reference formulation of the contact energy: exact gradients, conserved energy, restitution
// on every feature, and independence of the points that describe a solid.
#include "tests/solver/contact_energy/contact_energy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace firn::contact_energy {
namespace {

constexpr double kMass = 0.0137;      // kg
constexpr double kStiffness = 6.1e5;  // N/m
constexpr double kSpeed = 1.4;        // m/s
constexpr double kDegree = std::numbers::pi / 180;

struct Dice {
  std::mt19937_64 engine;
  explicit Dice(std::uint64_t seed) : engine(seed) {}
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  }
  double normal() { return std::normal_distribution<double>()(engine); }
  Vec3 direction() { return Vec3(normal(), normal(), normal()).normalized(); }
  Quat turn() { return Quat(normal(), normal(), normal(), normal()).normalized(); }
};

std::vector<Vec3> box_corners(const Vec3& size) {
  std::vector<Vec3> out;
  for (int i = 0; i < 8; ++i)
    out.push_back(0.5 * size.cwiseProduct(Vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1)));
  return out;
}

Solid box(const Vec3& size) { return make_solid(box_corners(size)); }

// A random convex polyhedron with corners on a sphere, its origin inside.
Solid random_solid(Dice& dice, int corners, double radius) {
  std::vector<Vec3> points;
  for (int i = 0; i < 4; ++i)  // around the origin
    points.push_back(radius * (Vec3(i == 1 || i == 2 ? 1 : -1, i == 1 || i == 3 ? 1 : -1,
                                    i == 2 || i == 3 ? 1 : -1) +
                               0.4 * dice.direction())
                                  .normalized());
  for (int i = 4; i < corners; ++i) points.push_back(radius * dice.direction());
  return make_solid(points);
}

// A crescent whose dish has `facets` facets: its hull below the plane of each facet.
Body crescent(int arcs, int facets, double dish) {
  constexpr double kChord = 0.061, kWidth = 0.0206, kDepth = 0.0137, kTip = 0.002;
  std::vector<Vec3> outline;
  for (const double y : {-kWidth / 2, kWidth / 2}) {
    for (int i = 0; i <= arcs; ++i) {
      const double u = -1 + 2.0 * i / arcs;
      outline.emplace_back(u * kChord / 2, y, -kTip - (kDepth - kTip) * (1 - u * u));
    }
    for (const double x : {-kChord / 2, kChord / 2}) outline.emplace_back(x, y, 0);
  }
  const Solid hull = make_solid(outline);
  Body body;
  for (int i = 0; i < facets; ++i) {
    const auto at = [&](int k) {
      const double u = -1 + 2.0 * k / facets;
      return Vec3(u * kChord / 2, 0, -dish * (1 - u * u));
    };
    const Vec3 normal = Vec3::UnitY().cross(at(i) - at(i + 1)).normalized();
    const double offset = normal.dot(at(i));
    std::vector<Vec3> points;
    for (const Vec3& v : hull.vertices) {
      if (normal.dot(v) <= offset) points.push_back(v);
    }
    for (const Solid::Edge& e : hull.edges) {
      const Vec3 &from = hull.vertices[e.vertex[0]], &to = hull.vertices[e.vertex[1]];
      const double first = normal.dot(from) - offset, last = normal.dot(to) - offset;
      if ((first < 0) != (last < 0)) points.push_back(from + first / (first - last) * (to - from));
    }
    body.push_back(make_solid(points));
  }
  return body;
}

Law elastic_law(double smoothing) {
  Law law;
  law.stiffness = kStiffness;
  law.smoothing = smoothing;
  return law;
}

struct Rigid {
  Vec3 inertia;  // kg m^2, principal
  Pose pose;
  Quat turn = Quat::Identity();
  Vec3 velocity = Vec3::Zero();
  Vec3 momentum = Vec3::Zero();  // kg m^2/s, angular, world

  void set(const Quat& q, const Vec3& at) {
    turn = q;
    pose = {q.toRotationMatrix(), at};
  }
  Vec3 spin(const Mat3& rotation) const {
    return rotation * (rotation.transpose() * momentum).cwiseQuotient(inertia);
  }
  Vec3 spin() const { return spin(pose.rotation); }
  double kinetic() const {
    return 0.5 * kMass * velocity.squaredNorm() + 0.5 * momentum.dot(spin());
  }
  void kick(const Vec3& force, const Vec3& moment, double dt) {
    velocity += dt / kMass * force;
    momentum += dt * moment;
  }
  static Quat turned(const Vec3& angle, const Quat& q) {
    const double size = angle.norm();
    return size > 0 ? Quat(Eigen::AngleAxisd(size, angle / size)) * q : q;
  }
  void drift(double dt) {  // midpoint rule for the rotation
    Vec3 w = spin();
    for (int i = 0; i < 2; ++i) w = spin(turned(0.5 * dt * w, turn).toRotationMatrix());
    set(turned(dt * w, turn).normalized(), pose.translation + dt * velocity);
  }
};

Vec3 box_inertia(const Vec3& size) {
  const Vec3 s = size.cwiseProduct(size);
  return kMass / 12 * Vec3(s.y() + s.z(), s.x() + s.z(), s.x() + s.y());
}

// The least height of a above b along z at which they do not touch, below `top`; none if they miss.
double height_of_touch(const Law& law, const Body& a, const Rigid& ra, const Body& b,
                       const Rigid& rb, double top) {
  const auto energy = [&](double z) {
    Pose pose = ra.pose;
    pose.translation.z() = z;
    return elastic_contact(law, a, pose, b, rb.pose).energy;
  };
  double z = top;
  while (z > -top && energy(z) <= 0) z -= 5e-4;
  if (z <= -top) return -1;
  double low = z, high = z + 5e-4;
  for (int i = 0; i < 12; ++i) {
    const double middle = 0.5 * (low + high);
    (energy(middle) > 0 ? low : high) = middle;
  }
  return high;
}

// Kinetic energy after an elastic impact of two free bodies over that before; 0 if they miss.
double energy_kept(const Law& law, const Body& a, Rigid ra, const Body& b, Rigid rb, double dt,
                   double phase) {
  const double z = height_of_touch(law, a, ra, b, rb, 0.08);
  if (z < 0) return 0;
  ra.pose.translation.z() = z + phase * kSpeed * dt;
  ra.velocity = {0, 0, -kSpeed};
  const double before = ra.kinetic() + rb.kinetic();
  Wrench w;
  int apart = 0;
  for (int step = 0; step < 40000 && apart < 30; ++step) {
    ra.kick(w.force, w.moment_a, dt / 2);
    rb.kick(-w.force, w.moment_b, dt / 2);
    ra.drift(dt);
    rb.drift(dt);
    const Contact c = elastic_contact(law, a, ra.pose, b, rb.pose);
    w = c.wrench;
    apart = c.energy > 0 ? 0 : apart + 1;
    ra.kick(w.force, w.moment_a, dt / 2);
    rb.kick(-w.force, w.moment_b, dt / 2);
  }
  return (ra.kinetic() + rb.kinetic()) / before;
}

// Compares the wrench with differences of the energy, at random overlapping places.
void expect_gradient(const Law& law, const Body& a, const Body& b, Dice& dice) {
  Rigid ra, rb;
  ra.set(dice.turn(), {dice.between(-5e-3, 5e-3), dice.between(-5e-3, 5e-3), 0});
  rb.set(dice.turn(), Vec3::Zero());
  const double z = height_of_touch(law, a, ra, b, rb, 0.08);
  if (z < 0) return;
  ra.pose.translation.z() = z - 2e-4;
  const Contact c = elastic_contact(law, a, ra.pose, b, rb.pose);
  ASSERT_GT(c.energy, 0);
  const double size = c.wrench.force.norm();
  for (int i = 0; i < 3; ++i) {
    const auto moved = [&](double h) {
      Pose p = ra.pose;
      p.translation[i] += h;
      return elastic_contact(law, a, p, b, rb.pose).energy;
    };
    const auto turned = [&](bool is_a, double h) {
      Pose p = is_a ? ra.pose : rb.pose;
      p.rotation = Eigen::AngleAxisd(h, Vec3::Unit(i)).toRotationMatrix() * p.rotation;
      return is_a ? elastic_contact(law, a, p, b, rb.pose).energy
                  : elastic_contact(law, a, ra.pose, b, p).energy;
    };
    EXPECT_NEAR(-(moved(1e-8) - moved(-1e-8)) / 2e-8, c.wrench.force[i], 1e-6 * size);
    EXPECT_NEAR(-(turned(true, 1e-6) - turned(true, -1e-6)) / 2e-6, c.wrench.moment_a[i],
                1e-7 * size);
    EXPECT_NEAR(-(turned(false, 1e-6) - turned(false, -1e-6)) / 2e-6, c.wrench.moment_b[i],
                1e-7 * size);
  }
}

TEST(ContactEnergy, WrenchIsTheGradientForRandomPolyhedra) {
  Dice dice(1);
  for (int i = 0; i < 40; ++i) {
    const Body a{random_solid(dice, 5 + i % 9, 0.011)}, b{random_solid(dice, 5 + i % 7, 0.011)};
    expect_gradient(elastic_law(i % 2 ? 1e-3 : 1e-4), a, b, dice);
  }
}

TEST(ContactEnergy, WrenchIsTheGradientForConcaveBodies) {
  Dice dice(2);
  for (int i = 0; i < 12; ++i) {
    const Body a = crescent(8, 1 + i % 4, 1e-3), b = crescent(6, 4, 3e-3);
    expect_gradient(elastic_law(3e-4), a, b, dice);
  }
}

TEST(ContactEnergy, ElasticImpactsOfPolyhedraKeepTheirEnergy) {
  Dice dice(3);
  int hits = 0;
  for (int i = 0; i < 40; ++i) {
    const bool boxes = i % 2 == 0;
    const Vec3 size(0.03, 0.02, 0.012);
    const Body a{boxes ? box(size) : random_solid(dice, 7, 0.011)};
    const Body b{boxes ? box(size) : random_solid(dice, 7, 0.011)};
    Rigid ra, rb;
    ra.inertia = rb.inertia = boxes ? box_inertia(size) : box_inertia(Vec3::Constant(0.016));
    ra.set(dice.turn(), {dice.between(-0.01, 0.01), dice.between(-0.008, 0.008), 0});
    rb.set(dice.turn(), Vec3::Zero());
    const double kept =
        energy_kept(elastic_law(3e-4), a, ra, b, rb, boxes ? 1e-5 : 1e-6, dice.between(0, 1));
    if (kept == 0) continue;
    ++hits;
    EXPECT_NEAR(kept, 1, boxes ? 5e-3 : 2e-3) << "impact " << i;
  }
  EXPECT_GT(hits, 25);
}

TEST(ContactEnergy, NearFlatElasticImpactsKeepTheirEnergy) {
  Dice dice(4);
  const Body cube{box(Vec3::Constant(0.022))};
  for (int i = 0; i < 30; ++i) {
    Rigid ra, rb;
    ra.inertia = rb.inertia = box_inertia(Vec3::Constant(0.022));
    const Vec3 axis(dice.between(-1, 1), dice.between(-1, 1), 0);
    const Quat tilt(Eigen::AngleAxisd(axis.norm() * 3 * kDegree, axis.normalized()));
    const Quat yaw(Eigen::AngleAxisd(dice.between(-3, 3), Vec3::UnitZ()));
    ra.set(tilt * yaw, {dice.between(-0.011, 0.011), dice.between(-0.011, 0.011), 0});
    rb.set(Quat::Identity(), Vec3::Zero());
    const double kept =
        energy_kept(elastic_law(i % 2 ? 1e-3 : 1e-4), cube, ra, cube, rb, 1e-5, dice.between(0, 1));
    EXPECT_NEAR(kept, 1, 4e-3) << "impact " << i;
  }
}

TEST(ContactEnergy, ElasticImpactsOfCrescentsKeepTheirEnergy) {
  Dice dice(5);
  const Body body = crescent(8, 3, 1.5e-3);
  int hits = 0;
  for (int i = 0; i < 12; ++i) {
    Rigid ra, rb;
    ra.inertia = rb.inertia = box_inertia({0.061, 0.0206, 0.0137});
    const bool in_dish = i % 2 == 0;
    ra.set(in_dish ? Quat(Eigen::AngleAxisd(dice.between(-20, 20) * kDegree, dice.direction()))
                   : dice.turn(),
           {dice.between(-0.02, 0.02), dice.between(-8e-3, 8e-3), 0});
    rb.set(in_dish ? Quat::Identity() : dice.turn(), Vec3::Zero());
    const double kept =
        energy_kept(elastic_law(3e-4), body, ra, body, rb, 1e-5, dice.between(0, 1));
    if (kept == 0) continue;
    ++hits;
    EXPECT_NEAR(kept, 1, 3e-3) << "impact " << i;
  }
  EXPECT_GT(hits, 7);
}

// Drops a cube without spin; the part of its kinetic energy and of its speed that it keeps.
struct Rebound {
  double energy, speed, deepest;
};
Rebound drop_cube(const Law& law, const Quat& turn) {
  constexpr double kSide = 0.022, kStep = 1e-5;
  const Solid cube = box(Vec3::Constant(kSide)), floor = box({0.2, 0.2, 0.1});
  Rigid r;
  r.inertia = box_inertia(Vec3::Constant(kSide));
  double lowest = 0;
  for (const Vec3& v : cube.vertices) lowest = std::min(lowest, (turn * v).z());
  r.set(turn, {0.003, -0.004, 0.05 - lowest + 3e-6});
  r.velocity = {0, 0, -kSpeed};
  const double before = r.kinetic();
  std::vector<Memory> memory;
  Rebound out{0, 0, 0};
  Wrench w;
  int apart = 0;
  for (int step = 0; step < 40000 && apart < 200; ++step) {
    r.kick(w.force, w.moment_a, kStep / 2);
    r.drift(kStep);
    const Contact c =
        hysteretic_contact(law, cube, r.pose, floor, {}, memory, r.velocity, r.spin(), kStep);
    w = c.wrench;
    memory = c.memory;
    out.deepest = std::max(out.deepest, c.deepest);
    apart = w.force.norm() > 0 ? 0 : apart + 1;
    r.kick(w.force, w.moment_a, kStep / 2);
  }
  out.energy = r.kinetic() / before;
  out.speed = r.velocity.z() / kSpeed;
  return out;
}

TEST(ContactEnergy, FacesEdgesAndCornersReboundAlike) {
  Law law = elastic_law(1e-3);
  const Quat edge(Eigen::AngleAxisd(45 * kDegree, Vec3::UnitX()));
  const Quat corner = Quat::FromTwoVectors(Vec3(1, 1, 1), Vec3(0, 0, -1));
  const double overlap = kSpeed * std::sqrt(kMass / kStiffness);
  for (const double e : {0.1, 0.3, 0.5, 0.8, 0.95}) {
    law.restitution = e;
    for (const Quat& turn : {Quat::Identity(), edge, corner}) {
      const Rebound r = drop_cube(law, turn);
      EXPECT_NEAR(r.speed, e, std::max(0.01 * e, 0.002)) << e;
      EXPECT_NEAR(r.deepest, overlap, 0.01 * overlap) << e;
    }
  }
}

// An impact on one edge keeps more energy than one on the face. A near-flat impact is two edge
// impacts, one after the other, and lies between them.
TEST(ContactEnergy, NearFlatImpactsKeepNoMoreThanTwoEdgeImpacts) {
  Dice dice(6);
  for (const double e : {0.3, 0.5}) {
    Law law = elastic_law(1e-3);
    law.restitution = e;
    for (int i = 0; i < 15; ++i) {
      const Vec3 axis(dice.between(-1, 1), dice.between(-1, 1), 0);
      const Rebound r =
          drop_cube(law, Quat(Eigen::AngleAxisd(axis.norm() * 3 * kDegree, axis.normalized())));
      EXPECT_LT(r.energy, e * e + 0.05) << e << " impact " << i;
      EXPECT_GT(r.energy, 0.3 * e * e) << e << " impact " << i;
    }
  }
}

TEST(ContactEnergy, TiltStiffnessOfAFace) {
  constexpr double kSide = 0.02, kDepth = 1e-5, kSmoothing = 1e-3;
  const Law law = elastic_law(kSmoothing);
  const Body cube{box(Vec3::Constant(kSide))}, floor{box({0.2, 0.2, 0.1})};
  for (const double azimuth : {0.0, 20.0, 45.0}) {
    const Vec3 axis(std::cos(azimuth * kDegree), std::sin(azimuth * kDegree), 0);
    const auto moment = [&](double angle) {
      const Pose pose{Eigen::AngleAxisd(angle, axis).toRotationMatrix(),
                      {0, 0, 0.05 + kSide / 2 - kDepth}};
      return elastic_contact(law, cube, pose, floor, {}).wrench.moment_a.dot(axis);
    };
    const double stiffness = -(moment(1e-5) - moment(-1e-5)) / 2e-5;
    // The weight pushes at the height of the face: the moment of a face that slides aside is left
    // out.
    const double lever = kStiffness * kDepth * kSide / 2;
    EXPECT_NEAR((stiffness - lever) / (kStiffness * kSide * kSide),
                0.25 * (1 + 2 * kDepth / kSmoothing), 0.005);
  }
}

// Points on faces and edges, and points inside, change nothing.
TEST(ContactEnergy, MorePointsOfTheSameSolidChangeNothing) {
  Dice dice(7);
  const Vec3 size(0.03, 0.02, 0.012);
  const Law law = elastic_law(5e-4);
  const Body floor{box({0.2, 0.2, 0.1})};
  const Body plain{box(size)};
  for (int i = 0; i < 20; ++i) {
    std::vector<Vec3> points = box_corners(size);
    for (int k = 0; k < 12; ++k) {
      Vec3 p(dice.between(-0.5, 0.5), dice.between(-0.5, 0.5), dice.between(-0.5, 0.5));
      for (int axis = 0; axis < k % 3; ++axis)
        p[(axis + k) % 3] = p[(axis + k) % 3] > 0 ? 0.5 : -0.5;
      points.push_back(size.cwiseProduct(p));
    }
    const Body cut{make_solid(points)};
    ASSERT_EQ(cut[0].faces.size(), 6u);
    const Vec3 axis = i % 2 ? Vec3(dice.normal(), dice.normal(), 0) : dice.direction();
    const Quat turn(Eigen::AngleAxisd(dice.between(0, i % 2 ? 3 * kDegree : 3), axis.normalized()));
    double lowest = 0;
    for (const Vec3& v : plain[0].vertices) lowest = std::min(lowest, (turn * v).z());
    const Pose pose{turn.toRotationMatrix(), {0, 0, 0.05 - lowest - 2e-4}};
    const Contact p = elastic_contact(law, plain, pose, floor, {});
    const Contact q = elastic_contact(law, cut, pose, floor, {});
    EXPECT_NEAR(q.energy, p.energy, 1e-9 * p.energy);
    EXPECT_LT((q.wrench.force - p.wrench.force).norm(), 1e-8 * p.wrench.force.norm());
    EXPECT_LT((q.wrench.moment_a - p.wrench.moment_a).norm(), 1e-10 * p.wrench.force.norm());
  }
}

// The same convex solid listed several times is one contact.
TEST(ContactEnergy, OverlappingPiecesShareTheStiffness) {
  const Law law = elastic_law(5e-4);
  const Body floor{box({0.2, 0.2, 0.1})};
  const Solid cube = box(Vec3::Constant(0.02));
  const Pose pose{Eigen::AngleAxisd(0.01, Vec3(1, 2, 0).normalized()).toRotationMatrix(),
                  {0, 0, 0.05 + 0.0099}};
  const Contact once = elastic_contact(law, {cube}, pose, floor, {});
  const Contact thrice = elastic_contact(law, {cube, cube, cube}, pose, floor, {});
  ASSERT_GT(once.energy, 0);
  EXPECT_NEAR(thrice.energy, once.energy, 1e-12 * once.energy);
  EXPECT_LT((thrice.wrench.force - once.wrench.force).norm(), 1e-9 * once.wrench.force.norm());
}

// Two faces at right angles bear the full stiffness each.
TEST(ContactEnergy, WallsAtRightAnglesBearFully) {
  const Law law = elastic_law(3e-4);
  const Solid cube = box(Vec3::Constant(0.02));
  std::vector<Vec3> wall;
  for (const Vec3& v : box_corners({0.1, 0.2, 0.2})) wall.push_back(v + Vec3(0.06, 0, 0.1));
  const Body corner{box({0.3, 0.3, 0.1}), make_solid(wall)};
  const double depth = 1e-4;
  const Pose pose{Mat3::Identity(), {depth, 0, 0.05 + 0.01 - depth}};
  const Contact c = elastic_contact(law, {cube}, pose, corner, {});
  EXPECT_NEAR(c.energy, 2 * 0.5 * kStiffness * depth * depth, 0.08 * kStiffness * depth * depth);
}

}  // namespace
}  // namespace firn::contact_energy
