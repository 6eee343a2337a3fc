// The reference formulation of the contact energy: exact gradients, conserved energy, restitution
// on every feature, and independence of the points that describe a solid.
#include "tests/solver/contact_energy/contact_energy.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/solver/contact_energy/impacts.h"

namespace firn::contact_energy {
namespace {

Law elastic_law(double smoothing) {
  Law law;
  law.stiffness = kStiffness;
  law.smoothing = smoothing;
  return law;
}

auto contact_of(const Law& law, const Body& a, const Body& b) {
  return [&law, &a, &b](const Pose& p, const Pose& q) { return elastic_contact(law, a, p, b, q); };
}

double energy_kept(const Law& law, const Body& a, const Rigid& ra, const Body& b, const Rigid& rb,
                   double dt, double phase) {
  return impact(contact_of(law, a, b), ra, rb, dt, phase).kept;
}

void expect_gradient(const Law& law, const Body& a, const Body& b, Dice& dice) {
  Rigid ra, rb;
  ra.set(dice.turn(), {dice.between(-5e-3, 5e-3), dice.between(-5e-3, 5e-3), 0});
  rb.set(dice.turn(), Vec3::Zero());
  expect_gradient(contact_of(law, a, b), ra, rb, 1e-7);
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
    place_crescents(dice, i % 2 == 0, ra, rb);
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
