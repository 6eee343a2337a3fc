#include "experiments/inspection/contact_inspection.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/error_of.h"
#include "validation/verification/fixtures/scenes.h"

namespace firn {
namespace {

// A ball that falls onto a plane without gravity: its history up to its end.
struct Bounce {
  double mass = 0, before = 0, after = 0;  // kg, m/s
  std::vector<HistoryRow> rows;
  std::vector<PatchEvent> events;
};

Bounce bounce(double restitution, double speed, std::uint64_t every) {
  const Shape ball = make_sphere(0.01, scenes::ice_options(0.004, 2e4, -1));
  Model model = scenes::body_on_plane(ball, scenes::law(0, restitution));
  model.gravity.setZero();
  model.timestep = 1e-6;
  Solver solver(model);
  solver.insert(0, {0, 0, 0.0101}, Quat::Identity(), {0, 0, -speed}, Vec3::Zero());
  ContactHistory history({0, 1}, every);
  history.add_step(solver, false);
  constexpr int kSteps = 6000;
  for (int i = 0; i < kSteps; ++i) {
    solver.step();
    history.add_step(solver, i + 1 == kSteps);
  }
  return {0.004, speed, solver.particles().velocity[0].z(), history.rows(), history.events()};
}

TEST(ContactHistory, LoopOfABounceEnclosesItsLoss) {
  for (const double restitution : {0.2, 0.3, 0.5, 0.8}) {
    SCOPED_TRACE(restitution);
    const Bounce b = bounce(restitution, 1, 1);
    ASSERT_GT(b.after, 0);
    const double lost = b.rows.back().work_normal;
    // Velocity Verlet: exact but for rounding.
    const double kinetic = 0.5 * b.mass * (b.before * b.before - b.after * b.after);
    EXPECT_NEAR(lost, kinetic, 1e-10 * kinetic);
    EXPECT_EQ(b.rows.back().work_friction, 0);
    // The law loses m v^2 (1 - e^2) / 2; the floor of the unloading branch (a thousandth of K s)
    // gives some of 0.001 K s^2 / 2 back, a thousandth of what was stored.
    const double law = 0.5 * b.mass * b.before * b.before * (1 - restitution * restitution);
    EXPECT_NEAR(lost, law, 1.5e-3 * 0.5 * b.mass * b.before * b.before);
    // And so does the loop that the table draws, force over overlap, by trapezia. Where it begins
    // and ends inside a step is not in the table.
    double loop = 0;
    for (std::size_t i = 1; i < b.rows.size(); ++i) {
      const HistoryRow &p = b.rows[i - 1], &q = b.rows[i];
      if (p.patches == 0 || q.patches == 0) continue;
      loop += 0.5 * (p.normal_force + q.normal_force) * (p.gap - q.gap);
    }
    EXPECT_NEAR(loop, lost, 1e-3 * law);
    // It began and ended once.
    ASSERT_EQ(b.events.size(), 2u);
    EXPECT_EQ(b.events[0].after, 1);
    EXPECT_EQ(b.events[1].after, 0);
    EXPECT_GT(b.events[1].time, b.events[0].time);
  }
}

TEST(ContactHistory, SparseRowsMissNothing) {
  const Bounce all = bounce(0.3, 1, 1), some = bounce(0.3, 1, 1000);
  EXPECT_EQ(some.rows.size(), 7u);
  EXPECT_EQ(all.rows.back().work_normal, some.rows.back().work_normal);
  double peak = 0, sparse_peak = 0;
  int new_patches = 0, lost_patches = 0;
  for (const HistoryRow& r : all.rows) peak = std::max(peak, r.normal_force);
  for (const HistoryRow& r : some.rows) {
    sparse_peak = std::max(sparse_peak, r.peak_normal_force);
    new_patches += r.new_patches;
    lost_patches += r.lost_patches;
  }
  // v sqrt(m K)
  EXPECT_NEAR(peak, std::sqrt(0.004 * 2e4), 0.01 * peak);
  EXPECT_EQ(sparse_peak, peak);
  EXPECT_EQ(new_patches, 1);
  EXPECT_EQ(lost_patches, 1);
}

// A cube slides to rest: all of its energy goes into friction, and what its rocking dissipates.
TEST(ContactHistory, SlidingBlockLosesItsEnergyToFriction) {
  const Shape cube = make_box(Vec3::Constant(0.02), scenes::ice_options(0.008, 2e4, 5e-4));
  Model model = scenes::body_on_plane(cube, scenes::law(0.3, 0.3));
  model.timestep = 1e-5;
  Solver solver(model);
  solver.insert(0, {0, 0, 0.01}, Quat::Identity(), {0.5, 0, 0}, Vec3::Zero());
  ContactHistory history({0, -1}, 100);
  const double start = solver.energy().kinetic + solver.energy().gravitational;
  history.add_step(solver, false);
  for (int i = 0; i < 30000; ++i) {
    solver.step();
    history.add_step(solver, false);
  }
  const double end = solver.energy().kinetic + solver.energy().gravitational;
  const HistoryRow& last = history.rows().back();
  EXPECT_NEAR(last.work_normal + last.work_friction, start - end, 1e-6 * start);
  EXPECT_NEAR(last.work_friction, 0.5 * 0.008 * 0.25, 0.05 * 0.001);
  int sliding = 0;
  for (const HistoryRow& r : history.rows()) {
    if (r.patches == 0 || r.time > 0.15) continue;
    ++sliding;
    EXPECT_NEAR(r.friction_mobilization, 1, 1e-9);
    EXPECT_NEAR(r.friction, 0.3 * r.normal_force, 1e-9);
  }
  EXPECT_GT(sliding, 100);
  EXPECT_LT(last.friction_mobilization, 1);
}

Solver bed(int crescents) {
  Model model = scenes::empty(scenes::law(0.1, 0.3), scenes::law(0.3, 0.3));
  scenes::add_particles(model, scenes::add_shape(model, scenes::crescent()), crescents);
  scenes::add_box_of_planes(model, Vec3::Zero(), {0.14, 0.12, 0});
  model.timestep = 1e-5;
  Solver solver(model);
  scenes::scatter(solver, 0, crescents, Vec3::Zero(), {0.14, 0.12, 0.25}, 3);
  scenes::run(solver, 0.2);
  return solver;
}

TEST(ForceBalance, ForcesExplainTheMotionToRounding) {
  const Solver solver = bed(20);
  const std::uint64_t hash = solver.hash();
  double moved_by_contacts = 0;  // N
  for (int i = 0; i < 20; ++i) {
    const ForceBalance b = force_balance(solver, i);
    EXPECT_LT(b.sum_mismatch, 1e-13 * b.scale) << i;
    // Momenta are known to some roundings of their size, and divided by the step.
    const ParticleState& state = solver.particles();
    const Shape& shape = solver.model().shapes[0];
    constexpr double kRounding = 20 * std::numeric_limits<double>::epsilon() / 1e-5;  // 1/s
    const double momentum = shape.mass * state.velocity[i].norm();
    const double angular_momentum = shape.inertia.maxCoeff() * state.angular_velocity[i].norm();
    EXPECT_LT(b.force_error, 1e-13 * b.scale + kRounding * momentum) << i;
    EXPECT_LT(b.moment_error, 1e-13 * b.moment_scale + kRounding * angular_momentum) << i;
    moved_by_contacts = std::max(moved_by_contacts, (b.mass_acceleration - b.weight).norm());
    EXPECT_NEAR(b.weight.z(), -0.0137 * 9.81, 1e-4);
  }
  EXPECT_GT(moved_by_contacts, 0.01);
  EXPECT_EQ(solver.hash(), hash);  // looking changes nothing
}

TEST(ContactSummary, CountsAndSorts) {
  const Solver solver = bed(20);
  const ContactSummary s = summarize_contacts(solver, 5);
  EXPECT_EQ(s.present, 20u);
  EXPECT_LE(s.pairs, s.patches);
  EXPECT_LE(s.patches, s.points);
  EXPECT_EQ(s.patches + s.non_touching_patches, solver.diagnostics().patches);
  ASSERT_EQ(s.most_loaded.size(), 5u);
  EXPECT_EQ(s.most_loaded[0].normal_force, s.force_largest);
  EXPECT_EQ(s.deepest[0].overlap, s.overlap_largest);
  for (std::size_t k = 1; k < 5; ++k) {
    EXPECT_GE(s.most_loaded[k - 1].normal_force, s.most_loaded[k].normal_force);
    EXPECT_GE(s.deepest[k - 1].overlap, s.deepest[k].overlap);
  }
  EXPECT_LE(s.force_median, s.force_p99);
  EXPECT_LE(s.overlap_median, s.overlap_p99);
}

// Who is asked first sees the forces on itself.
TEST(ContactView, IsTurnedToTheBodyThatIsAsked) {
  const Solver solver = bed(20);
  int pairs = 0;
  for (const Contact& c : solver.contacts()) {
    if (c.b >= 20 || !(c.normal_force > 0)) continue;
    ++pairs;
    const std::vector<ContactView> there = select_contacts(solver, {c.a, c.b});
    const std::vector<ContactView> back = select_contacts(solver, {c.b, c.a});
    ASSERT_EQ(there.size(), back.size());
    for (std::size_t k = 0; k < there.size(); ++k) {
      EXPECT_EQ(there[k].contact.a, c.a);
      EXPECT_EQ(back[k].contact.a, c.b);
      EXPECT_EQ(there[k].contact.force, -back[k].contact.force);
      EXPECT_EQ(there[k].contact.normal, -back[k].contact.normal);
      EXPECT_EQ(there[k].contact.moment_a, back[k].contact.moment_b);
    }
  }
  EXPECT_GT(pairs, 5);
}

TEST(FindBody, KnowsIdsAndNames) {
  Model named = bed(2).model();
  named.boundaries[0].name = "floor";
  EXPECT_EQ(find_body(named, "1", "--pair"), 1);
  EXPECT_EQ(find_body(named, "floor", "--pair"), 2);
  for (const char* unknown : {"2", "-1", "1.5", "", "flor", "1 "})
    EXPECT_THAT(test::error_of([&] { find_body(named, unknown, "--pair"); }),
                testing::HasSubstr("expected a particle 0 ... 1 or a boundary, \"floor"))
        << unknown;
}

}  // namespace
}  // namespace firn
