// Adhesion against closed forms: what hangs, what sticks after an impact, what an incline holds.
#include <gtest/gtest.h>

#include <cmath>

#include "solver/contact/contact_law.h"
#include "validation/verification/fixtures/scenes.h"

namespace firn {
namespace {

constexpr double kG = scenes::kGravity;
constexpr double kStiffness = 1e4, kMass = 5e-3, kRadius = 10e-3, kRestitution = 0.6;
constexpr double kWeight = kMass * kG;
constexpr double kSmallFloor = 1e-6;

Interaction sticky(double force, double fraction = 0) {
  Interaction law = scenes::law(0.4, kRestitution);
  law.minimum_unloading_ratio = kSmallFloor;
  law.adhesion_force = force;
  law.adhesion_stiffness_fraction = fraction;
  return law;
}

Shape ball() { return make_sphere(kRadius, scenes::ice_options(kMass, kStiffness, kRadius)); }
Shape box() {
  return make_box(Vec3::Constant(2 * kRadius), scenes::ice_options(kMass, kStiffness, 1e-3));
}

// Under a ceiling z = 0, pressed into it as far as balances its weight.
Solver hung(const Shape& shape, double force, const Vec3& tilt = Vec3::Zero()) {
  Model model = scenes::empty(sticky(0), sticky(force));
  scenes::add_particles(model, scenes::add_shape(model, shape));
  scenes::add_plane(model, Vec3::Zero(), -Vec3::UnitZ());
  model.timestep = 2e-5;
  Solver solver(model);
  const double overlap = std::max(1e-9, (force - kWeight) / kStiffness);
  solver.insert(0, Vec3(0, 0, -kRadius + overlap), Quat::Identity(), tilt, Vec3::Zero());
  return solver;
}

TEST(Adhesion, HoldsWhatHangsUpToItsForceAndNoMore) {
  for (const Shape& shape : {ball(), box()}) {
    Solver held = hung(shape, 1.02 * kWeight);
    scenes::run(held, 0.5);
    EXPECT_NEAR(held.particles().position[0].z(), -kRadius, 1e-6);
    ASSERT_EQ(held.contacts().size(), 1u);
    // Once per contact, however many points lie in it.
    EXPECT_NEAR(held.contacts()[0].adhesion, 1.02 * kWeight, 1e-12);
    EXPECT_NEAR(held.contacts()[0].force.z(), kWeight, 0.02 * kWeight);
    EXPECT_NEAR((held.contacts()[0].force - held.load(0).force).norm(), 0, 1e-12);
    EXPECT_NEAR((held.contacts()[0].moment_a - held.load(0).moment).norm(), 0, 1e-12);
    Solver lost = hung(shape, 0.98 * kWeight);
    scenes::run(lost, 0.5);
    EXPECT_LT(lost.particles().position[0].z(), -kRadius - 1e-3);
  }
}

// A ball hits a plane without gravity: what it keeps of its energy is known.
struct Impact {
  double speed = 0;  // m/s, after it; 0: it stays
  Energy energy;
  double before = 0;  // J
};
Impact impact(double force, double fraction, double speed) {
  Model model = scenes::body_on_plane(ball(), sticky(force, fraction));
  model.gravity = Vec3::Zero();
  model.timestep = 1e-6;
  Solver solver(model);
  solver.insert(0, Vec3(0, 0, kRadius + 1e-6), Quat::Identity(), Vec3(0, 0, -speed), Vec3::Zero());
  Impact out;
  out.before = scenes::mechanical(solver.energy());
  scenes::run(solver, 0.02);
  out.energy = solver.energy();
  const bool away = solver.particles().position[0].z() > kRadius + 1e-6;
  out.speed = away ? solver.particles().velocity[0].z() : 0;
  return out;
}

// F = K s - F0 on the way in; the loop of the spring, K s^2 (1 - e^2) / 2, is lost.
TEST(Adhesion, ConstantForceTakesItsShareOfAnImpact) {
  const double speed = 0.05, e2 = kRestitution * kRestitution;
  for (const double force : {0.02, 0.04, 0.06}) {
    const double deepest =
        (force + std::sqrt(force * force + kStiffness * kMass * speed * speed)) / kStiffness;
    const double lost = 0.5 * kStiffness * deepest * deepest * (1 - e2);
    const double left = 0.5 * kMass * speed * speed - lost;
    ASSERT_GT(left, 0);
    const Impact found = impact(force, 0, speed);
    EXPECT_NEAR(found.speed, std::sqrt(2 * left / kMass), 2e-3 * speed) << force;
    EXPECT_NEAR(found.energy.dissipated_normal, lost, 2e-3 * found.before) << force;
    EXPECT_NEAR(scenes::mechanical(found.energy) + found.energy.dissipated_normal, found.before,
                1e-3 * found.before);
  }
  EXPECT_EQ(impact(2.0, 0, speed).speed, 0);  // lost > what there is: it stays
}

// F = (1 - f) K s on the way in: e'^2 = 1 - (1 - e^2) / (1 - f), and it stays from f = e^2 on.
TEST(Adhesion, FractionOfStiffnessLowersTheRestitution) {
  const double speed = 0.05, e2 = kRestitution * kRestitution;
  for (const double fraction : {0.05, 0.2, 0.3}) {
    const Impact found = impact(0, fraction, speed);
    EXPECT_NEAR(found.speed, speed * std::sqrt(1 - (1 - e2) / (1 - fraction)), 2e-3 * speed)
        << fraction;
    EXPECT_NEAR(scenes::mechanical(found.energy) + found.energy.dissipated_normal, found.before,
                1e-3 * found.before);
  }
  EXPECT_EQ(impact(0, e2 + 0.02, speed).speed, 0);
}

// Pressed in to s and drawn out slowly, a contact pulls most where the spring lets go:
// f K s (1 - e^2) / (1 - lambda e^2), less the floor.
TEST(Adhesion, PullOffGrowsWithThePreload) {
  PairCoefficients law;
  law.stiffness = kStiffness;
  law.unloading_stiffness_ratio = 1 / (kRestitution * kRestitution);
  law.minimum_unloading_ratio = 0.01;
  law.adhesion_fraction = 0.5;
  ContactPoint point;
  point.stiffness_fraction = 1;
  const double deepest = 1e-4, step = 1e-9, e2 = kRestitution * kRestitution;
  double force = kStiffness * deepest, most = 0;
  for (double s = deepest; s > 0; s -= step) {
    const double previous = force;
    compute_normal_force(previous, kStiffness, kStiffness / e2, law.minimum_unloading_ratio, s,
                         -step, force);
    most = std::max(most, adhesion_of(law, point, -s, 1).force - force);
  }
  const double there = deepest * (1 - e2) / (1 - law.minimum_unloading_ratio * e2);
  EXPECT_NEAR(most, (law.adhesion_fraction - law.minimum_unloading_ratio) * kStiffness * there,
              1e-3 * most);
}

// A block on an incline holds up to m g sin a = mu (m g cos a + F0).
TEST(Adhesion, InclineHoldsByFrictionOfThePulledContact) {
  const double angle = 0.6, mu = 0.4, force = kWeight * (std::sin(angle) / mu - std::cos(angle));
  ASSERT_GT(force, 0);
  for (const double share : {0.95, 1.05}) {
    Model model = scenes::empty(sticky(0), sticky(share * force));
    scenes::add_particles(model, scenes::add_shape(model, box()));
    const Vec3 normal(std::sin(angle), 0, std::cos(angle));
    scenes::add_plane(model, Vec3::Zero(), normal);
    model.timestep = 2e-5;
    Solver solver(model);
    const double pressed = (kWeight * std::cos(angle) + share * force) / kStiffness;
    solver.insert(0, (kRadius - pressed) * normal, shortest_rotation(Vec3::UnitZ(), normal),
                  Vec3::Zero(), Vec3::Zero());
    scenes::run(solver, 0.5);
    const double way = (solver.particles().position[0] - kRadius * normal).norm();
    if (share > 1)
      EXPECT_LT(way, 1e-3);  // it creeps: docs/contact.md
    else
      EXPECT_GT(way, 10e-3);
  }
}

// Balls let go as a column spread less far when they stick to each other and to the floor.
TEST(Adhesion, HeapStandsSteeper) {
  const auto spread = [](double force) {
    Model model = scenes::empty(sticky(force), sticky(force));
    scenes::add_particles(model, scenes::add_shape(model, ball()), 72);
    scenes::add_plane(model, Vec3::Zero(), Vec3::UnitZ(), false);
    model.timestep = 5e-5;
    Solver solver(model);
    for (int i = 0; i < 72; ++i) {
      const Vec3 cell(i % 3, i / 3 % 3, i / 9);
      const double shift = 1e-3 * (i / 9 % 2);
      solver.insert(i, 2.1 * kRadius * cell + Vec3(shift, shift, kRadius), Quat::Identity(),
                    Vec3::Zero(), Vec3::Zero());
    }
    scenes::run(solver, 0.8);
    double sum = 0;
    for (const Vec3& p : solver.particles().position)
      sum += (p - 2.1 * kRadius * Vec3(1, 1, 0)).head<2>().squaredNorm();
    return std::sqrt(sum / 72);
  };
  EXPECT_LT(spread(20 * kWeight), 0.7 * spread(0));
}

TEST(Adhesion, RefusesWhatCannotWork) {
  for (Interaction law : {sticky(-1), sticky(0, 1.0), sticky(0, -0.1)}) {
    Model model = scenes::body_on_plane(ball(), law);
    model.timestep = 1e-5;
    EXPECT_THROW(Solver{model}, InputError);
  }
  Interaction without_floor = sticky(1);
  without_floor.minimum_unloading_ratio = 0;
  Model model = scenes::body_on_plane(ball(), without_floor);
  model.timestep = 1e-5;
  EXPECT_THROW(Solver{model}, InputError);
}

}  // namespace
}  // namespace firn
