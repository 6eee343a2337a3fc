// What must not change a simulation: its seed's bytes, an interruption, the way a body is
// cut into parts; and what must never grow: its energy. More of it is in the verification suite.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <stdexcept>
#include <vector>

#include "solver/core/parallel.h"
#include "solver/state/workspace.h"
#include "tests/support/dice.h"
#include "tests/support/environment.h"
#include "validation/verification/fixtures/scenes.h"

namespace firn {
namespace {

// Crescents that fall into a closed box of planes.
Model small_box(int crescents, double restitution = 0.3) {
  Model model = scenes::empty(scenes::law(0.1, restitution), scenes::law(0.3, restitution));
  scenes::add_particles(model, scenes::add_shape(model, scenes::crescent()), crescents);
  scenes::add_box_of_planes(model, Vec3::Zero(), {0.14, 0.12, 0});
  model.timestep = 1e-5;
  return model;
}

Solver filled(const Model& model, double height, std::uint64_t seed) {
  Solver solver(model);
  const int count = static_cast<int>(model.particles.size());
  scenes::scatter(solver, 0, count, Vec3::Zero(), {0.14, 0.12, height}, seed);
  return solver;
}

TEST(Determinism, SameSeedGivesTheSameBytesAndAnotherDoesNot) {
  const Model model = small_box(20);
  std::vector<std::vector<std::byte>> states;
  for (const std::uint64_t seed : {7, 7, 8}) {
    Solver solver = filled(model, 0.25, seed);
    scenes::run(solver, 0.15);
    ASSERT_GT(solver.diagnostics().patches, 0u);
    states.push_back(solver.save());
  }
  EXPECT_TRUE(states[0] == states[1]);
  EXPECT_FALSE(states[0] == states[2]);
}

// Cubes in contact, on their way to rest.
Solver falling(const Model& model) {
  Solver solver = filled(model, 0.25, 3);
  scenes::run(solver, 0.12);
  return solver;
}

Solver copy_of(const Solver& solver) {
  Solver copy(solver.model());
  copy.restore(solver.save());
  return copy;
}

// The names of the groups of state that differ.
std::string different_groups(const std::vector<GroupHash>& a, const std::vector<GroupHash>& b) {
  std::string names;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i].hash != b[i].hash) names += std::string(names.empty() ? "" : ", ") + a[i].group;
  return names;
}

// A state is restored at every seventh step of a fall into contact, and continues for a while with
// the hashes of the run that never stopped.
TEST(Determinism, ResumedAtAnyStepGoesOnWithTheSameHashes) {
  constexpr std::size_t kSteps = 280, kAhead = 40;
  const Model model = small_box(20);
  Solver whole = falling(model);
  std::vector<std::vector<GroupHash>> hashes;
  std::vector<std::vector<std::byte>> states;
  for (std::size_t step = 0; step < kSteps + kAhead; ++step) {
    hashes.push_back(whole.group_hashes());
    states.push_back(whole.save());
    whole.step();
  }
  ASSERT_GT(whole.diagnostics().patches, 0u);
  for (std::size_t from = 0; from < kSteps; from += 7) {
    Solver resumed(model);
    resumed.restore(states[from]);
    for (std::size_t step = from; step < from + kAhead; ++step) {
      ASSERT_EQ(different_groups(hashes[step], resumed.group_hashes()), "")
          << "step " << step << ", resumed at " << from;
      resumed.step();
    }
  }
}

// Deferred steps, complete steps and any mixture of both give the same bits, with any reads
// between.
TEST(Determinism, DeferredStepsGiveTheSameBits) {
  Solver silent = falling(small_box(20));
  Solver asked = copy_of(silent);
  const auto ask = [&](int what) {
    asked.complete_step();
    if (what == 0) return asked.particles().velocity[0].norm();
    if (what == 1) return asked.energy().kinetic;
    if (what == 2) return asked.load(3).force.norm();
    if (what == 3) return static_cast<double>(asked.hash());
    if (what == 4) return static_cast<double>(asked.save().size());
    if (what == 5) return static_cast<double>(asked.diagnostics().points);
    return asked.particles().angular_velocity[1].norm();
  };
  for (int step = 0; step < 300; ++step) {
    for (Solver* solver : {&silent, &asked}) {
      if (step == 137) solver->remove_particle(5);
      if (step == 212) solver->remove_boundary(0);
      if (solver == &silent || step % 5 == 0)
        solver->step_deferred();
      else
        solver->step();
    }
    if (step % 3 > 0) {
      EXPECT_GE(ask(step % 7), 0);
    }
  }
  ASSERT_GT(silent.diagnostics().patches, 0u);
  silent.complete_step();
  asked.complete_step();
  EXPECT_EQ(different_groups(silent.group_hashes(), asked.group_hashes()), "");
  EXPECT_EQ(silent.particles().peak_normal_force, asked.particles().peak_normal_force);
  EXPECT_EQ(silent.energy().kinetic, asked.energy().kinetic);
}

// Reads between the two half kicks would show velocities of an earlier time.
TEST(Solver, ReadsOfADeferredStepAreRefused) {
  Solver solver = falling(small_box(20));
  const auto reads = [&] {
    const Solver& s = solver;
    return std::vector<std::function<void()>>{[&] { s.particles(); }, [&] { s.energy(); },
                                              [&] { s.load(0); },     [&] { s.save(); },
                                              [&] { s.hash(); },      [&] { s.group_hashes(); }};
  };
  solver.step_deferred();
  for (const auto& read : reads()) EXPECT_THROW(read(), std::logic_error);
  EXPECT_NO_THROW(solver.boundaries());
  EXPECT_NO_THROW(solver.contacts());
  EXPECT_NO_THROW(solver.diagnostics());
  solver.complete_step();
  for (const auto& read : reads()) EXPECT_NO_THROW(read());
  solver.step_deferred();
  solver.step();
  for (const auto& read : reads()) EXPECT_NO_THROW(read());
}

// Copies that accessors return follow every change of the state.
TEST(Solver, AccessorsFollowTheState) {
  Solver solver = falling(small_box(20));
  for (int step = 0; step < 300; ++step) {
    solver.step_deferred();
    solver.complete_step();
    const Solver again = copy_of(solver);
    ASSERT_EQ(solver.particles().velocity[3], again.particles().velocity[3]) << step;
    ASSERT_EQ(solver.boundaries()[0].impulse, again.boundaries()[0].impulse) << step;
  }
  ASSERT_FALSE(solver.boundaries()[0].impulse.isZero(0));
  solver.clear_boundary_loads();
  EXPECT_TRUE(solver.boundaries()[0].impulse.isZero(0));
}

// Counted by the steps, and by walking through all contacts: over new lists and removals, before
// the first step and after a restart.
TEST(Diagnostics, CountsWhatIsThere) {
  std::size_t most = 0;
  const auto expect_counts = [&](const Solver& solver) {
    const std::vector<Contact> contacts = solver.contacts();
    most = std::max(most, contacts.size());
    std::size_t points = 0;
    for (const Contact& contact : contacts) points += contact.points.size();
    const Diagnostics& diagnostics = solver.diagnostics();
    ASSERT_EQ(diagnostics.patches, contacts.size()) << "at step " << solver.steps();
    ASSERT_EQ(diagnostics.points, points) << "at step " << solver.steps();
  };
  Solver solver = filled(small_box(20), 0.25, 3);
  expect_counts(solver);
  scenes::run(solver, 0.11);
  const std::uint64_t lists = solver.diagnostics().rebuilds;
  for (int step = 0; step < 2000; ++step) {
    if (step == 700) solver.remove_particle(5);
    if (step == 900) solver.remove_boundary(0);
    solver.step();
    expect_counts(solver);
    if (step % 100 == 0) expect_counts(copy_of(solver));
  }
  EXPECT_GT(most, 10u);
  EXPECT_GT(solver.diagnostics().rebuilds, lists + 3);
}

TEST(StateHash, NamesTheGroupOfTheStateThatChanged) {
  Solver a = falling(small_box(20));
  Solver b = copy_of(a);
  EXPECT_EQ(a.hash(), b.hash());
  b.clear_boundary_loads();
  EXPECT_EQ(different_groups(a.group_hashes(), b.group_hashes()), "boundary loads");
  EXPECT_NE(a.hash(), b.hash());
  b.step();
  EXPECT_NE(different_groups(a.group_hashes(), b.group_hashes()).find("positions"),
            std::string::npos);
}

// Crescents fall, touch and come to rest.
TEST(Determinism, WideAndPlainInstructionsGiveTheSameBytes) {
  std::vector<std::vector<std::byte>> states;
  for (const char* instructions : {"baseline", "avx2"}) {
    const test::EnvironmentVariable wish("FIRN_INSTRUCTIONS", instructions);
    try {
      ASSERT_EQ(instruction_set(), instructions);
    } catch (const InputError& e) {
      GTEST_SKIP() << e.what();
    }
    Solver solver = filled(small_box(60), 0.4, 7);
    scenes::run(solver, 0.3);
    ASSERT_GT(solver.diagnostics().contact_searches, 1000u);
    states.push_back(solver.save());
  }
  EXPECT_TRUE(states[0] == states[1]);
}

// A cloud of spinning dice that is large enough for tasks of several ranges, which fetch ahead and
// have separate scratch memory: with one thread a single task, with more smaller ones.
TEST(Determinism, TasksOfSeveralRangesGiveTheSameBytes) {
  constexpr int kSide = 28, kSteps = 40;
  Model model = scenes::empty(scenes::law(0.1, 0.3), scenes::law(0.1, 0.3));
  model.timestep = 1e-4;
  const int shape = scenes::add_shape(
      model, make_box(Vec3::Constant(0.01), scenes::ice_options(1e-3, 1e4, 1e-3)));
  scenes::add_particles(model, shape, kSide * kSide * kSide);
  std::vector<std::uint64_t> hashes;
  for (const int threads : {1, 2, 3}) {
    model.numerics.threads = threads;
    Solver solver(model);
    Dice dice(5);
    for (int i = 0; i < kSide * kSide * kSide; ++i) {
      const Vec3 place(i % kSide, i / kSide % kSide, i / kSide / kSide);
      solver.insert(i, 0.0118 * place, Quat::Identity(), dice.vector(1), dice.vector(100));
    }
    for (int step = 0; step < kSteps; ++step) solver.step();
    const Diagnostics diagnostics = solver.diagnostics();
    EXPECT_GT(diagnostics.contact_searches, 1000u);
    EXPECT_GT(diagnostics.rebuilds, 1u);
    EXPECT_GT(blocks_per_task(threads, diagnostics.pairs / kPairsPerBlock), 1u)
        << diagnostics.pairs;
    hashes.push_back(solver.hash());
  }
  EXPECT_EQ(hashes[1], hashes[0]);
  EXPECT_EQ(hashes[2], hashes[0]);
}

TEST(Determinism, UnknownInstructionsAreRefused) {
  const test::EnvironmentVariable wish("FIRN_INSTRUCTIONS", "abacus");
  EXPECT_THROW(Solver(small_box(1)), InputError);
}

TEST(Checkpoint, RestoredSolverGoesOnBitForBit) {
  const Model model = small_box(20);
  Solver solver = filled(model, 0.25, 3);
  scenes::run(solver, 0.12);
  const std::vector<std::byte> saved = solver.save();
  scenes::run(solver, 0.05);

  Solver restored(model);
  restored.restore(saved);
  EXPECT_TRUE(restored.save() == saved);
  scenes::run(restored, 0.05);
  EXPECT_TRUE(restored.save() == solver.save());
  EXPECT_EQ(restored.hash(), solver.hash());
  EXPECT_EQ(restored.time(), solver.time());
  EXPECT_EQ(restored.energy().dissipated_friction, solver.energy().dissipated_friction);
}

TEST(Checkpoint, StateOfAnotherModelOrDamagedBytesAreRefused) {
  Solver solver = filled(small_box(3), 0.25, 3);
  scenes::run(solver, 0.01);
  std::vector<std::byte> saved = solver.save();
  Solver other(small_box(4));
  EXPECT_THROW(other.restore(saved), RunError);
  Model stiffer = small_box(3);
  stiffer.shapes[0].stiffness *= 2;
  Solver second(stiffer);
  EXPECT_THROW(second.restore(saved), RunError);
  saved.resize(saved.size() / 2);
  Solver same(small_box(3));
  EXPECT_THROW(same.restore(saved), RunError);
  EXPECT_THROW(same.restore({}), RunError);
}

// Nothing but gravity works on crescents in a box at rest: kinetic, potential and elastic energy
// together can only fall. Where a contact's touching set changes its springs are distributed again,
// which may store a little: a thousandth of what is lost.
TEST(Energy, NeverGrowsInAClosedBox) {
  Solver solver = filled(small_box(30), 0.35, 5);
  double lowest = scenes::mechanical(solver.energy());
  const double start = lowest;
  double rises = 0;
  for (int i = 0; i < 4000; ++i) {
    scenes::run(solver, 1e-4);
    const double now = scenes::mechanical(solver.energy());
    if (now > lowest) rises += now - lowest;
    lowest = std::min(lowest, now);
  }
  const double lost = start - lowest;
  EXPECT_GT(lost, 0.1);
  EXPECT_LT(rises, 1e-3 * lost);
  // The books balance: what is gone is in the accounts of dissipation.
  const Energy e = solver.energy();
  EXPECT_NEAR(e.dissipated_normal + e.dissipated_friction, lost, 0.02 * lost);
  EXPECT_LT(solver.diagnostics().largest_overlap, 1e-3);
}

// The particles of a bed are inserted again at the same places. No work has loaded their new
// springs, which therefore give more energy than they take. The bed moves, comes to rest, and
// raises no alarm.
TEST(Energy, BedInsertedAgainComesToRestWithoutAlarm) {
  constexpr int kCubes = 100;
  Model model = small_box(kCubes);
  model.timestep = 2e-5;
  Solver first = filled(model, 1, 5);
  scenes::run(first, 0.8);
  Solver again(model);
  for (int i = 0; i < kCubes; ++i)
    again.insert(i, first.particles().position[i], first.shape_orientation(i), Vec3::Zero(),
                 Vec3::Zero());
  scenes::run(again, 0.5);
  const Energy e = again.energy();
  EXPECT_LT(e.dissipated_normal, 0);  // or this is not the case it is meant for
  EXPECT_LT(e.kinetic, 1e-7);
  EXPECT_LT(again.diagnostics().energy_error, 1e-2 * e.elastic);
}

// A crescent dropped without spin or gravity, `down` (shape axes) first; its speed after 1 m/s.
double rebound(const Vec3& down, double restitution) {
  const Shape shape = scenes::crescent();
  Model model = scenes::body_on_plane(shape, scenes::law(0, restitution));
  model.gravity.setZero();
  model.timestep = 5e-6;
  Solver solver(model);
  const Quat turn = shortest_rotation(down, -Vec3::UnitZ());
  double lowest = 0;
  for (const Vec3& vertex : shape.mesh.vertices)
    lowest = std::min(lowest, (turn * (vertex - shape.centroid)).z());
  solver.insert(0, {0, 0, shape.surface_deviation + 1e-5 - lowest}, turn, {0, 0, -1}, Vec3::Zero());
  scenes::run(solver, 0.01);
  return solver.particles().velocity[0].z();
}

// On its bottom and on its rim the contact is symmetric about the center of mass, so the rebound is
// the restitution, floor included (0.3 -> 0.3014, 0.5 -> 0.5006).
TEST(Crescent, DroppedOnBottomOrRimReboundsWithTheRestitution) {
  for (const Vec3& down : {Vec3(0, 0, -1), Vec3(0, 0, 1)}) {
    SCOPED_TRACE(::testing::Message() << "down " << down.transpose());
    EXPECT_NEAR(rebound(down, 0.3), 0.3014, 3e-3);
    EXPECT_NEAR(rebound(down, 0.5), 0.5006, 3e-3);
  }
}

// On its leaning side the center of the face is not below the center of mass: the body turns a
// little and keeps somewhat less speed.
TEST(Crescent, DroppedFlatOnItsSideReboundsWithTheRestitution) {
  const double draft = CrescentParameters{}.draft;
  const Vec3 side(0, std::cos(draft), -std::sin(draft));
  EXPECT_NEAR(rebound(side, 0.3), 0.3014, 0.02);
}

// Two crescents, side face on side face with 10 um of overlap, after one step from rest: the
// impulse and its moment on the first, about its center of mass.
struct Push {
  Vec3 impulse, moment;
};

Push side_on_side(int parts) {
  CrescentParameters p = named_crescent("mass-matched", {}).parameters;
  p.parts = parts;
  const Shape shape = scenes::crescent(p);
  Model model = scenes::empty(scenes::law(0, 0.3), scenes::law(0, 0.3));
  scenes::add_particles(model, scenes::add_shape(model, shape), 2);
  model.gravity.setZero();
  model.timestep = 1e-6;
  Solver solver(model);
  // The second one lies upside down next to the first, so that the leaning sides are parallel.
  const Vec3 normal(0, std::cos(p.draft), -std::sin(p.draft));
  const Vec3 along = normal.cross(Vec3::UnitX());
  Pose second;
  second.rotation = Eigen::AngleAxisd(std::numbers::pi, Vec3::UnitX()).toRotationMatrix();
  second.translation =
      (p.width * std::cos(p.draft) - 10e-6) * normal + 12e-3 * Vec3::UnitX() + 3e-3 * along;
  const Pose first;
  solver.insert(0, scenes::center_of_mass(shape, first), Quat(first.rotation), Vec3::Zero(),
                Vec3::Zero());
  solver.insert(1, scenes::center_of_mass(shape, second), Quat(second.rotation), Vec3::Zero(),
                Vec3::Zero());
  solver.step();
  const Mat3 axes = shape.shape_from_body.toRotationMatrix();
  const Mat3 inertia = axes * shape.inertia.asDiagonal() * axes.transpose();
  return {shape.mass * solver.particles().velocity[0],
          inertia * solver.particles().angular_velocity[0]};
}

// Force within 0.5 % and torque within 1.5 % of the uncut body's, however many parts.
TEST(Crescent, ForceDoesNotDependOnTheNumberOfParts) {
  const Push reference = side_on_side(2);
  ASSERT_GT(reference.impulse.norm(), 0);
  for (const int parts : {3, 4, 6, 12}) {
    SCOPED_TRACE(parts);
    const Push push = side_on_side(parts);
    EXPECT_LT((push.impulse - reference.impulse).norm(), 5e-3 * reference.impulse.norm());
    EXPECT_LT((push.moment - reference.moment).norm(), 1.5e-2 * reference.moment.norm());
  }
}

}  // namespace
}  // namespace firn
