// Contacts of boundaries with each other. Closed forms: validation/verification, machine.*.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/error_of.h"
#include "validation/verification/fixtures/mechanisms.h"

namespace firn {
namespace {

using testing::HasSubstr;
using namespace scenes;

// A loose block that slides and turns on a floor, between it and a lever that a motor turns, next
// to a heap of particles.
Model workshop() {
  Model model = mechanism();
  add_particles(model, 0, 5);
  Joint pivot = hinge(Vec3::UnitY());
  pivot.motors.push_back({});
  pivot.motors[0].speed = 2;
  pivot.motors[0].max_load = 0.3;
  pivot.motors[0].no_load_speed = 5;
  pivot.armature = 1e-4;
  const int lever =
      add_mover(model, "lever", 0.2, {0.1, 0, 0.15}, Vec3::Constant(1e-3), {pivot}, {0, 0, 0.15});
  const int block = add_mover(model, "block", 0.5, {0.16, 0, 0.03}, Vec3::Constant(4e-4),
                              {slider(Vec3::UnitX()), slider(Vec3::UnitZ()), hinge(Vec3::UnitY())},
                              {0.16, 0, 0.03});
  const int arm = add_panel(model, "arm", {0, -0.02, 0.14}, {0.2, 0.02, 0.16});
  const int load = add_panel(model, "load", {0.12, -0.04, 0.001}, {0.2, 0.04, 0.06});
  const int floor = add_plane(model, Vec3::Zero(), Vec3::UnitZ());
  model.boundaries[arm].frame = lever;
  model.boundaries[load].frame = block;
  add_contact(model, arm, load, 0.3, 0.5, 2e5);
  add_contact(model, load, floor, 0.2, 0.4, 1e6);
  model.timestep = 2e-5;
  return model;
}

Solver start(int threads) {
  Model model = workshop();
  model.numerics.threads = threads;
  Solver solver(model);
  for (int i = 1; i <= 5; ++i)
    solver.insert(i, {0.3 + 0.002 * i, 0, 0.05 * i}, Quat::Identity(), Vec3::Zero(), Vec3::Zero());
  return solver;
}

TEST(BoundaryContacts, AreTheSameForAnyNumberOfThreadsAndAfterAnyResumption) {
  Solver reference = start(1), threaded = start(3);
  run(reference, 0.3);
  run(threaded, 0.3);
  EXPECT_EQ(reference.hash(), threaded.hash());
  const auto contacts = reference.boundary_contacts();
  EXPECT_GT(contacts[0].dissipated_normal + contacts[0].dissipated_friction, 0);
  EXPECT_GT(contacts[1].dissipated_friction, 0);
  Random random(7);
  for (int trial = 0; trial < 5; ++trial) {
    const double at = random.uniform(0.01, 0.29);
    Solver first = start(1);
    run(first, at);
    Solver second(workshop());
    second.restore(first.save());
    while (second.steps() < reference.steps()) second.step();
    EXPECT_EQ(second.hash(), reference.hash()) << "resumed at " << at << " s";
  }
}

TEST(BoundaryContacts, PushBothBoundariesAlike) {
  Solver solver(workshop());  // without particles
  for (int k = 0; k < 15000; ++k) {
    solver.step();
    if (k % 500 != 0) continue;
    const auto contacts = solver.boundary_contacts();
    const auto walls = solver.boundaries();
    const double scale = 1 + walls[1].impulse.norm();
    // The lever feels the block, the block lever and floor, the floor the block.
    EXPECT_NEAR((walls[0].impulse - contacts[0].impulse).norm(), 0, 1e-12 * scale);
    EXPECT_NEAR((walls[2].impulse + contacts[1].impulse).norm(), 0, 1e-12 * scale);
    EXPECT_NEAR((walls[0].impulse + walls[1].impulse + walls[2].impulse).norm(), 0, 1e-12 * scale);
  }
}

TEST(BoundaryContacts, EndWhenABoundaryIsRemoved) {
  Solver solver = start(1);
  run(solver, 0.3);
  EXPECT_GT(solver.boundary_contacts()[1].normal_force, 0);
  solver.remove_boundary(2);
  solver.step();
  EXPECT_EQ(solver.boundary_contacts()[1].normal_force, 0);
  EXPECT_EQ(solver.boundary_contacts()[1].patches, 0);
}

TEST(BoundaryContacts, StopARunWhenTheyAreTooSoft) {
  Model model = workshop();
  model.boundary_contacts[1].stiffness = 100;
  Solver solver(model);
  const std::string message = test::error_of<RunError>([&] { run(solver, 1); });
  EXPECT_THAT(message, HasSubstr("boundary \"load\" overlaps by"));
  EXPECT_THAT(message, HasSubstr("beyond the limit of"));
  EXPECT_THAT(message, HasSubstr("mm"));
}

TEST(BoundaryContacts, ShortenTheAdvisedTimeStep) {
  Model model = workshop();
  const double before = advise_timestep(model, 6).timestep;
  model.boundary_contacts[0].stiffness *= 1e4;
  const TimestepAdvice after = advise_timestep(model, 6);
  EXPECT_LT(after.timestep, 0.1 * before);
  EXPECT_THAT(after.reason, HasSubstr("arm on load"));
}

TEST(BoundaryContacts, AreRefusedBetweenPartsThatNoForceMoves) {
  Model model = workshop();
  model.boundaries[1].frame = model.boundaries[0].frame;
  EXPECT_THROW(Solver{model}, InputError);
  model = workshop();
  model.boundaries[0].frame = model.boundaries[1].frame = -1;
  EXPECT_THROW(Solver{model}, InputError);
}

}  // namespace
}  // namespace firn
