// What the solver reports of its contacts: closed forms, and equality with the forces that move the
// bodies.
#include <gtest/gtest.h>

#include <cmath>

#include "validation/verification/fixtures/scenes.h"

namespace firn {
namespace {

constexpr double kEdge = 0.02, kRounding = 5e-4;  // m
constexpr double kMass = 0.008;                   // kg

constexpr double kStiffness = 2e4;  // N/m

// A cube on the plane z = 0 of friction 0.3, with a velocity along x, in equilibrium along z: it
// sinks in by its weight over K, and rises by what the first half kick, which knows of no contact
// yet, will take.
Solver cube_on_plane(double speed) {
  const Shape cube =
      make_box(Vec3::Constant(kEdge), scenes::ice_options(kMass, kStiffness, kRounding));
  Model model = scenes::body_on_plane(cube, scenes::law(0.3, 0.3));
  model.timestep = 1e-5;
  Solver solver(model);
  solver.insert(0, {0, 0, 0.5 * kEdge - kMass * scenes::kGravity / kStiffness}, Quat::Identity(),
                {speed, 0, 0.5 * scenes::kGravity * model.timestep}, Vec3::Zero());
  return solver;
}

TEST(Contacts, CubeAtRestSharesItsWeightBetweenFourCorners) {
  Solver solver = cube_on_plane(0);
  scenes::run(solver, 0.1);
  const std::vector<Contact> contacts = solver.contacts();
  ASSERT_EQ(contacts.size(), 1u);
  const Contact& c = contacts[0];
  const double weight = kMass * scenes::kGravity;
  EXPECT_EQ(c.a, 0);
  EXPECT_EQ(c.b, 1);  // one particle: body 1 is the plane
  EXPECT_LT((c.normal + Vec3::UnitZ()).norm(), 1e-9);
  EXPECT_NEAR(c.normal_force, weight, 1e-9 * weight);
  EXPECT_NEAR(c.force.z(), weight, 1e-9 * weight);
  EXPECT_FALSE(c.sliding);
  EXPECT_NEAR(c.friction_limit, 0.3 * c.normal_force, 1e-15);
  EXPECT_DOUBLE_EQ(c.stiffness, kStiffness);
  ASSERT_EQ(c.points.size(), 4u);
  double sum = 0, share = 0, deepest = 0;
  for (const ContactPointInfo& spot : c.points) {
    EXPECT_NEAR(spot.force, weight / 4, 1e-9 * weight);
    EXPECT_NEAR(spot.stiffness_fraction, 0.25, 1e-6);
    // Corners of the flat face, midway between it and the plane.
    EXPECT_NEAR(std::abs(spot.position.x()), 0.5 * kEdge - kRounding, 1e-6);
    EXPECT_NEAR(std::abs(spot.position.y()), 0.5 * kEdge - kRounding, 1e-6);
    EXPECT_NEAR(spot.position.z(), 0.5 * spot.gap, 1e-6);
    sum += spot.force;
    share += spot.stiffness_fraction;
    deepest = std::max(deepest, -spot.gap);
  }
  EXPECT_NEAR(sum, c.normal_force, 1e-12);
  EXPECT_NEAR(share, 1, 1e-9);
  EXPECT_DOUBLE_EQ(c.overlap, deepest);
  EXPECT_DOUBLE_EQ(c.gap, -deepest);
}

TEST(Contacts, SlidingBlockUsesAllOfItsCap) {
  Solver solver = cube_on_plane(0.5);
  int looks = 0;
  // mu g t = 0.5 m/s after 0.17 s.
  for (int i = 0; i < 15; ++i) {
    scenes::run(solver, 0.01);
    for (const Contact& c : solver.contacts()) {
      if (!(c.normal_force > 0)) continue;
      ++looks;
      EXPECT_TRUE(c.sliding);
      EXPECT_NEAR(c.friction.norm(), 0.3 * c.normal_force, 1e-12);
      EXPECT_LT(c.friction.x(), 0);  // against the motion
      EXPECT_NEAR(c.friction.y(), 0, 1e-9);
    }
  }
  EXPECT_GT(looks, 10);
}

// Sums of all that is listed are what the next half kick reads, for force and moment, with and
// without rolling resistance.
TEST(Contacts, ListedForcesAreThoseThatMoveTheBodies) {
  for (const double rolling : {0.0, 0.05}) {
    Interaction ice = scenes::law(0.2, 0.3);
    ice.rolling_resistance = rolling;
    Model model = scenes::empty(ice, ice);
    scenes::add_particles(model, scenes::add_shape(model, scenes::crescent()), 20);
    scenes::add_box_of_planes(model, Vec3::Zero(), {0.14, 0.12, 0});
    model.timestep = 1e-5;
    Solver solver(model);
    scenes::scatter(solver, 0, 20, Vec3::Zero(), {0.14, 0.12, 0.25}, 3);
    for (int look = 0; look < 20; ++look) {
      scenes::run(solver, 0.01);
      std::vector<Vec3> force(20, Vec3::Zero()), moment(20, Vec3::Zero());
      double largest = 0;
      for (const Contact& c : solver.contacts()) {
        ASSERT_LT(c.a, c.b);
        force[c.a] += c.force;
        moment[c.a] += c.moment_a;
        largest = std::max(largest, c.normal_force);
        if (c.b < 20) {
          force[c.b] -= c.force;
          moment[c.b] += c.moment_b;
        }
        EXPECT_LE(c.friction.norm(), c.friction_limit * (1 + 1e-12));
        EXPECT_LE(std::abs(c.torsion), c.torsion_limit * (1 + 1e-12) + 1e-300);
        if (rolling == 0) {
          EXPECT_EQ(c.rolling, Vec3(Vec3::Zero()));
        }
      }
      for (int i = 0; i < 20; ++i) {
        const Solver::Load used = solver.load(i);
        EXPECT_LE((force[i] - used.force).norm(), 1e-12 * largest) << "particle " << i;
        // Levers are centimeters.
        EXPECT_LE((moment[i] - used.moment).norm(), 1e-13 * largest) << "particle " << i;
      }
    }
    EXPECT_GT(solver.diagnostics().patches, 20u);
  }
}

}  // namespace
}  // namespace firn
