// The contact energy from moments of the overlap volume: exact gradients, conserved energy, and
// independence of cuts.
#include "tests/solver/contact_energy/moment_energy.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/solver/contact_energy/impacts.h"

namespace firn::contact_energy {
namespace {

PiecedBody whole(const Body& solids) {
  PiecedBody out;
  for (const Solid& s : solids) out.push_back({s, {}, 1});
  return out;
}
PiecedBody whole(const Solid& solid) { return {{solid, {}, 1}}; }

auto contact_of(const PiecedBody& a, const PiecedBody& b) {
  return [&a, &b](const Pose& p, const Pose& q) { return moment_contact(kStiffness, a, p, b, q); };
}

// Cuts every piece by a plane, normal . x = offset. Parts thinner than `least` are not cut off.
void cut_pieces(const Vec3& normal, double offset, double least, std::vector<Solid>& pieces) {
  std::vector<Solid> out;
  for (const Solid& s : pieces) {
    std::vector<Vec3> below, above;
    double lowest = 0, highest = 0;
    for (const Vec3& v : s.vertices) {
      const double h = normal.dot(v) - offset;
      (h < 0 ? below : above).push_back(v);
      lowest = std::min(lowest, h);
      highest = std::max(highest, h);
    }
    if (-lowest < least || highest < least) {
      out.push_back(s);
      continue;
    }
    for (const Solid::Edge& e : s.edges) {
      const Vec3 &from = s.vertices[e.vertex[0]], &to = s.vertices[e.vertex[1]];
      const double first = normal.dot(from) - offset, last = normal.dot(to) - offset;
      if ((first < 0) == (last < 0)) continue;
      below.emplace_back(from + first / (first - last) * (to - from));
      above.push_back(below.back());
    }
    out.push_back(make_solid(below));
    out.push_back(make_solid(above));
  }
  pieces = std::move(out);
}

// The solid in 2 to 12 pieces or so.
PiecedSolid cut_at_random(const Solid& solid, double extent, Dice& dice) {
  PiecedSolid out{solid, {solid}, 1};
  const int cuts = static_cast<int>(dice.between(1, 4));
  for (int i = 0; i < cuts; ++i)
    cut_pieces(dice.direction(), dice.between(-0.3, 0.3) * extent, 0.02 * extent, out.pieces);
  return out;
}

TEST(MomentEnergy, WrenchIsTheGradientForRandomPolyhedra) {
  Dice dice(1);
  for (int i = 0; i < 40; ++i) {
    const PiecedBody a = whole(random_solid(dice, 5 + i % 9, 0.011));
    const PiecedBody b = whole(random_solid(dice, 5 + i % 7, 0.011));
    Rigid ra, rb;
    ra.set(dice.turn(), {dice.between(-5e-3, 5e-3), dice.between(-5e-3, 5e-3), 0});
    rb.set(dice.turn(), Vec3::Zero());
    expect_gradient(contact_of(a, b), ra, rb, 1e-8);
  }
}

TEST(MomentEnergy, WrenchIsTheGradientForConcaveBodies) {
  Dice dice(2);
  for (int i = 0; i < 16; ++i) {
    const PiecedBody a = whole(crescent(8, 1 + i % 4, 1e-3)), b = whole(crescent(6, 4, 3e-3));
    Rigid ra, rb;
    const bool in_dish = i % 2 == 0;
    ra.set(
        in_dish ? Quat(Eigen::AngleAxisd(dice.between(-0.3, 0.3), dice.direction())) : dice.turn(),
        {dice.between(-5e-3, 5e-3), dice.between(-5e-3, 5e-3), 0});
    rb.set(in_dish ? Quat::Identity() : dice.turn(), Vec3::Zero());
    expect_gradient(contact_of(a, b), ra, rb, 3e-8);
  }
}

TEST(MomentEnergy, ElasticImpactsOfPolyhedraKeepTheirEnergy) {
  Dice dice(3);
  int hits = 0;
  for (int i = 0; i < 150; ++i) {
    const bool boxes = i % 3 != 0;
    const Vec3 size = i % 3 == 1 ? Vec3(0.03, 0.02, 0.012) : Vec3::Constant(0.022);
    const PiecedBody a = whole(boxes ? box(size) : random_solid(dice, 7, 0.011));
    const PiecedBody b = whole(boxes ? box(size) : random_solid(dice, 7, 0.011));
    Rigid ra, rb;
    ra.inertia = rb.inertia = boxes ? box_inertia(size) : box_inertia(Vec3::Constant(0.016));
    ra.set(dice.turn(), {dice.between(-0.01, 0.01), dice.between(-0.008, 0.008), 0});
    rb.set(dice.turn(), Vec3::Zero());
    const double kept =
        impact(contact_of(a, b), ra, rb, boxes ? 1e-5 : 4e-6, dice.between(0, 1)).kept;
    if (kept == 0) continue;
    ++hits;
    EXPECT_NEAR(kept, 1, 2e-3) << "impact " << i;
  }
  EXPECT_GT(hits, 100);
}

TEST(MomentEnergy, NearFlatElasticImpactsKeepTheirEnergy) {
  Dice dice(4);
  const PiecedBody cube = whole(box(Vec3::Constant(0.022)));
  for (int i = 0; i < 100; ++i) {
    Rigid ra, rb;
    ra.inertia = rb.inertia = box_inertia(Vec3::Constant(0.022));
    const Quat yaw(Eigen::AngleAxisd(dice.between(-3, 3), Vec3::UnitZ()));
    ra.set(dice.tilt(3 * kDegree) * yaw,
           {dice.between(-0.011, 0.011), dice.between(-0.011, 0.011), 0});
    rb.set(Quat::Identity(), Vec3::Zero());
    const double kept = impact(contact_of(cube, cube), ra, rb, 1e-5, dice.between(0, 1)).kept;
    EXPECT_NEAR(kept, 1, 2e-3) << "impact " << i;
  }
}

TEST(MomentEnergy, ElasticImpactsOfCrescentsKeepTheirEnergy) {
  Dice dice(5);
  const PiecedBody body = whole(crescent(8, 3, 1.5e-3));
  int hits = 0;
  for (int i = 0; i < 60; ++i) {
    Rigid ra, rb;
    place_crescents(dice, i % 2 == 0, ra, rb);
    const double kept = impact(contact_of(body, body), ra, rb, 4e-6, dice.between(0, 1)).kept;
    if (kept == 0) continue;
    ++hits;
    EXPECT_NEAR(kept, 1, 2e-3) << "impact " << i;
  }
  EXPECT_GT(hits, 40);
}

// The mean overlap in a dish does not depend on the number of its facets.
TEST(MomentEnergy, FinerFacetsOfADishChangeLittle) {
  std::vector<double> overlap;
  for (const int facets : {4, 8, 12}) {
    Dice dice(6);
    const PiecedBody a = whole(crescent(12, 1, 1e-4)), b = whole(crescent(6, facets, 4e-3));
    double sum = 0;
    for (int i = 0; i < 12; ++i) {
      Rigid ra, rb;
      ra.inertia = rb.inertia = box_inertia({0.061, 0.0206, 0.0137});
      ra.set(Quat(Eigen::AngleAxisd(dice.between(-20, 20) * kDegree, dice.direction())),
             {dice.between(-0.01, 0.01), dice.between(-8e-3, 8e-3), 0});
      sum += impact(contact_of(a, b), ra, rb, 1e-5, 0.5).deepest;
    }
    overlap.push_back(sum / 12);
  }
  EXPECT_NEAR(overlap[1], overlap[0], 0.08 * overlap[0]);
  EXPECT_NEAR(overlap[2], overlap[0], 0.08 * overlap[0]);
}

TEST(MomentEnergy, CutsOfConvexSolidsChangeNothing) {
  Dice dice(7);
  int overlapping = 0;
  for (int i = 0; i < 60; ++i) {
    const Solid s = i % 2 ? box({0.03, 0.02, 0.012}) : random_solid(dice, 8, 0.011);
    const Solid t = i % 3 ? box({0.2, 0.2, 0.02}) : random_solid(dice, 8, 0.011);
    const PiecedBody a = whole(s), b = whole(t);
    const PiecedBody cut_a{cut_at_random(s, 0.02, dice)}, cut_b{cut_at_random(t, 0.02, dice)};
    Rigid ra, rb;
    ra.set(i % 4 == 0 ? dice.tilt(0.5 * kDegree) : dice.turn(),
           {dice.between(-5e-3, 5e-3), dice.between(-5e-3, 5e-3), 0});
    const double z = height_of_touch(contact_of(a, b), ra, rb, 0.08);
    if (z < 0) continue;
    ra.pose.translation.z() = z - dice.between(1e-5, 4e-4);
    const MomentContact p = moment_contact(kStiffness, a, ra.pose, b, rb.pose);
    const MomentContact q = moment_contact(kStiffness, cut_a, ra.pose, cut_b, rb.pose);
    overlapping += p.energy > 0;
    EXPECT_NEAR(q.energy, p.energy, 1e-9 * p.energy) << i;
    EXPECT_LT((q.wrench.force - p.wrench.force).norm(), 1e-8 * p.wrench.force.norm()) << i;
    EXPECT_LT((q.wrench.moment_a - p.wrench.moment_a).norm(), 1e-9 * p.wrench.force.norm()) << i;
    EXPECT_LT((q.wrench.moment_b - p.wrench.moment_b).norm(), 1e-9 * p.wrench.force.norm()) << i;
  }
  EXPECT_GT(overlapping, 40);
}

// The same solid listed several times is one contact.
TEST(MomentEnergy, EqualSolidsShareTheStiffness) {
  const PiecedBody floor = whole(box({0.2, 0.2, 0.1}));
  const Solid cube = box(Vec3::Constant(0.02));
  const Pose pose{Eigen::AngleAxisd(0.01, Vec3(1, 2, 0).normalized()).toRotationMatrix(),
                  {0, 0, 0.05 + 0.0099}};
  const MomentContact once = moment_contact(kStiffness, whole(cube), pose, floor, {});
  const MomentContact thrice =
      moment_contact(kStiffness, whole(Body{cube, cube, cube}), pose, floor, {});
  ASSERT_GT(once.energy, 0);
  EXPECT_NEAR(thrice.energy, once.energy, 1e-9 * once.energy);
  EXPECT_LT((thrice.wrench.force - once.wrench.force).norm(), 1e-9 * once.wrench.force.norm());
}

// Energy over K s^2 / 2: face 1, edge 1/2, corner 3/10.
TEST(MomentEnergy, StiffnessOfFeatures) {
  const PiecedBody cube = whole(box(Vec3::Constant(0.022))), floor = whole(box({0.2, 0.2, 0.1}));
  const auto ratio = [&](const PiecedBody& body, const Quat& turn, double depth) {
    double lowest = 0;
    for (const Vec3& v : body[0].solid.vertices) lowest = std::min(lowest, (turn * v).z());
    const Pose pose{turn.toRotationMatrix(), {0, 0, 0.05 - lowest - depth}};
    return moment_contact(kStiffness, body, pose, floor, {}).energy /
           (0.5 * kStiffness * depth * depth);
  };
  const Quat edge(Eigen::AngleAxisd(40 * kDegree, Vec3::UnitX()));
  const Quat corner = Quat::FromTwoVectors(Vec3(1, 0.9, 0.8), Vec3(0, 0, -1));
  for (const double depth : {1e-6, 1e-4}) {
    EXPECT_NEAR(ratio(cube, Quat::Identity(), depth), 1, 1e-6);
    EXPECT_NEAR(ratio(cube, edge, depth), 0.5, 1e-6);
    EXPECT_NEAR(ratio(cube, corner, depth), 0.3, 1e-6);
  }
  // A prism of many sides, as a cylinder: 24/35.
  std::vector<Vec3> prism;
  for (int i = 0; i < 48; ++i) {
    const double angle = i * std::numbers::pi / 24;
    for (const double x : {-0.01, 0.01})
      prism.emplace_back(x, 0.011 * std::cos(angle), 0.011 * std::sin(angle));
  }
  for (const double turn : {0.0, 0.05, 0.13})
    EXPECT_NEAR(ratio(whole(make_solid(prism)), Quat(Eigen::AngleAxisd(turn, Vec3::UnitX())), 1e-3),
                24.0 / 35, 0.025);
}

// Tilt stiffness of a square face over K a^2: 1/4, as for four corner points, however it is cut.
TEST(MomentEnergy, TiltStiffnessOfAFace) {
  constexpr double kSide = 0.02, kDepth = 2e-5;
  Dice dice(9);
  const Solid cube = box(Vec3::Constant(kSide)), floor = box({0.2, 0.2, 0.1});
  for (int i = 0; i < 12; ++i) {
    const PiecedBody a{i == 0 ? PiecedSolid{cube, {}, 1} : cut_at_random(cube, kSide, dice)};
    const PiecedBody b{i < 3 ? PiecedSolid{floor, {}, 1} : cut_at_random(floor, kSide, dice)};
    const double azimuth = dice.between(0, 3);
    const Vec3 axis(std::cos(azimuth), std::sin(azimuth), 0);
    const auto moment = [&](double angle) {
      const Pose pose{Eigen::AngleAxisd(angle, axis).toRotationMatrix(),
                      {0, 0, 0.05 + kSide / 2 - kDepth}};
      return moment_contact(kStiffness, a, pose, b, {}).wrench.moment_a.dot(axis);
    };
    const double stiffness = -(moment(1e-5) - moment(-1e-5)) / 2e-5;
    // The weight pushes at the height of the face: the moment of a face that slides aside.
    const double lever = kStiffness * kDepth * kSide / 2;
    EXPECT_NEAR((stiffness - lever) / (kStiffness * kSide * kSide), 0.25, 0.002) << i;
  }
}

// A crescent on both ends of its rim: K in all, and it tips about one end without resistance.
TEST(MomentEnergy, ACrescentStandsOnTwoRims) {
  const PiecedBody body = whole(crescent(8, 2, 1e-3)), floor = whole(box({0.2, 0.2, 0.1}));
  const Mat3 upside_down = Eigen::AngleAxisd(std::numbers::pi, Vec3::UnitX()).toRotationMatrix();
  const double depth = 1e-5;
  const auto contact = [&](double tilt) {
    Pose pose{Eigen::AngleAxisd(tilt, Vec3::UnitY()).toRotationMatrix() * upside_down, {0, 0, 0}};
    double lowest = 0;
    for (const PiecedSolid& s : body) {
      for (const Vec3& v : s.solid.vertices) lowest = std::min(lowest, (pose * v).z());
    }
    pose.translation.z() = 0.05 - lowest - depth;
    return moment_contact(kStiffness, body, pose, floor, {});
  };
  EXPECT_NEAR(contact(0).wrench.force.z(), kStiffness * depth, 0.005 * kStiffness * depth);
  for (const double tilt : {0.001, 0.003, 0.01}) {
    const Wrench w = contact(tilt).wrench;
    EXPECT_NEAR(w.force.z(), 0.5 * kStiffness * depth, 0.005 * kStiffness * depth);
    EXPECT_NEAR(-w.moment_a.y() / w.force.z(), 0.0305, 1e-5);
  }
}

// Two faces at right angles bear the full stiffness each.
TEST(MomentEnergy, WallsAtRightAnglesBearFully) {
  const Solid cube = box(Vec3::Constant(0.02));
  std::vector<Vec3> wall;
  for (const Vec3& v : box_corners({0.1, 0.2, 0.3})) wall.emplace_back(v + Vec3(0.06, 0, 0.1));
  const PiecedBody corner = whole(Body{box({0.3, 0.3, 0.1}), make_solid(wall)});
  const double depth = 1e-4;
  const Pose pose{Mat3::Identity(), {depth, 0, 0.05 + 0.01 - depth}};
  const MomentContact c = moment_contact(kStiffness, whole(cube), pose, corner, {});
  EXPECT_NEAR(c.energy, 2 * 0.5 * kStiffness * depth * depth, 0.02 * kStiffness * depth * depth);
}

// Drops a body without spin on a floor: its velocities after the impact.
struct Rebound {
  double energy, speed;
  Vec3 spin;
};
Rebound drop(double restitution, const PiecedSolid& body, const PiecedSolid& floor,
             const Vec3& inertia, const Quat& turn, double speed) {
  constexpr double kStep = 1e-5;
  Rigid r;
  r.inertia = inertia;
  double lowest = 0;
  for (const Vec3& v : body.solid.vertices) lowest = std::min(lowest, (turn * v).z());
  r.set(turn, {0.003, -0.004, 0.05 - lowest + 3e-6});
  r.velocity = {0, 0, -speed};
  const double before = r.kinetic();
  MomentMemory memory;
  Wrench w;
  int apart = 0;
  for (int step = 0; step < 40000 && apart < 200; ++step) {
    r.kick(w.force, w.moment_a, kStep / 2);
    r.drift(kStep);
    const MomentContact c = hysteretic_moment_contact(kStiffness, restitution, body, r.pose, floor,
                                                      {}, memory, r.velocity, r.spin(), kStep);
    w = c.wrench;
    memory = c.memory;
    apart = w.force.norm() > 0 ? 0 : apart + 1;
    r.kick(w.force, w.moment_a, kStep / 2);
  }
  return {r.kinetic() / before, r.velocity.z() / speed, r.spin()};
}

TEST(MomentEnergy, FacesEdgesAndCornersReboundAlike) {
  const PiecedSolid cube{box(Vec3::Constant(0.022)), {}, 1}, floor{box({0.2, 0.2, 0.1}), {}, 1};
  const Quat edge(Eigen::AngleAxisd(45 * kDegree, Vec3::UnitX()));
  const Quat corner = Quat::FromTwoVectors(Vec3(1, 1, 1), Vec3(0, 0, -1));
  for (const double e : {0.3, 0.5, 0.8, 0.95}) {
    for (const Quat& turn : {Quat::Identity(), edge, corner}) {
      const Rebound r = drop(e, cube, floor, box_inertia(Vec3::Constant(0.022)), turn, kSpeed);
      EXPECT_NEAR(r.speed, e, 0.01 * e);
    }
  }
}

TEST(MomentEnergy, NearFlatImpactsKeepNoMoreThanTwoEdgeImpacts) {
  Dice dice(10);
  const PiecedSolid cube{box(Vec3::Constant(0.022)), {}, 1}, floor{box({0.2, 0.2, 0.1}), {}, 1};
  for (const double e : {0.3, 0.5}) {
    for (int i = 0; i < 40; ++i) {
      const Rebound r =
          drop(e, cube, floor, box_inertia(Vec3::Constant(0.022)), dice.tilt(3 * kDegree), kSpeed);
      EXPECT_LT(r.energy, e * e + 0.02) << e << " impact " << i;
      EXPECT_GT(r.energy, 0.3 * e * e) << e << " impact " << i;
    }
  }
}

// A bar that lands on one edge, half a degree from level: the same spin however it and the floor
// are cut.
TEST(MomentEnergy, CutsOfABarDoNotChangeItsRebound) {
  Dice dice(11);
  const Vec3 size(0.06, 0.01, 0.01);
  const Solid bar = box(size), floor = box({0.3, 0.3, 0.1});
  const Quat turn = Quat(Eigen::AngleAxisd(0.5 * kDegree, Vec3::UnitY())) *
                    Quat(Eigen::AngleAxisd(45 * kDegree, Vec3::UnitX()));
  const Rebound uncut = drop(0.5, {bar, {}, 1}, {floor, {}, 1}, box_inertia(size), turn, 1);
  EXPECT_GT(uncut.spin.norm(), 0.5);
  for (int i = 0; i < 8; ++i) {
    PiecedSolid a{bar, {bar}, 1}, b{floor, {floor}, 1};
    for (int k = 1; k <= i; ++k)
      cut_pieces(Vec3::UnitX(), -0.03 + 0.06 * k / (i + 1), 1e-3, a.pieces);
    if (i % 2) b = cut_at_random(floor, 0.05, dice);
    const Rebound r = drop(0.5, a, b, box_inertia(size), turn, 1);
    EXPECT_LT((r.spin - uncut.spin).norm(), 1e-8 * uncut.spin.norm()) << i;
    EXPECT_NEAR(r.speed, uncut.speed, 1e-9) << i;
  }
}

}  // namespace
}  // namespace firn::contact_energy
