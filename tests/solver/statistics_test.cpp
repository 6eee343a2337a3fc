// Statistics of contacts against closed forms, and that they depend on nothing but the motion.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numbers>

#include "validation/verification/scenes.h"

namespace firn {
namespace {

using std::numbers::pi;

// A sphere of 1 g over the plane z = 0, without gravity.
constexpr double kRadius = 0.01, kMass = 1e-3, kStiffness = 1e4;  // m, kg, N/m

Model sphere_over_plane(double friction, double restitution) {
  const Shape ball = make_sphere(kRadius, scenes::ice_options(kMass, kStiffness, kRadius));
  Interaction law = scenes::law(friction, restitution);
  law.unloading_floor = 1e-6;
  Model model = scenes::body_on_plane(ball, law);
  model.gravity = Vec3::Zero();
  model.timestep = 1e-3 * std::sqrt(kMass / kStiffness);
  model.statistics.events = true;
  return model;
}

void run_for(Solver& solver, double duration) {
  const double end = solver.time() + duration;
  while (solver.time() < end) solver.step();
}

// The hysteretic spring loads for a quarter period of K and unloads for one of K / e^2: the peak is
// v sqrt(m K), and the impulse (1 + e) m v. What is left of the overlap then, 1 - e^2 of the
// largest, goes back at the speed e v under the floor of the law. The loss is (1 - e^2) m v^2 / 2.
TEST(Events, ImpactOfASphereHasTheClosedForms) {
  for (const double e : {0.3, 0.7, 1.0}) {
    const double v = 0.5;
    const Model model = sphere_over_plane(0, e);
    Solver solver(model);
    const Quat turned(Eigen::AngleAxisd(1.0, Vec3(1, 2, 3).normalized()));
    solver.insert(0, {0.3, 0.2, kRadius + 1e-5}, turned, {0, 0, -v}, Vec3::Zero());
    run_for(solver, 7 * std::sqrt(kMass / kStiffness));
    const std::vector<ContactEvent> events = solver.take_events();
    ASSERT_EQ(events.size(), 1u) << e;
    EXPECT_TRUE(solver.take_events().empty());
    EXPECT_TRUE(solver.open_events().empty());
    const ContactEvent& event = events[0];
    const double period = std::sqrt(kMass / kStiffness);
    EXPECT_EQ(event.a, 0);
    EXPECT_EQ(event.b, 1);
    EXPECT_NEAR(event.start, 1e-5 / v, 2 * model.timestep);
    EXPECT_NEAR(event.duration, ((1 + e) * pi / 2 + 1 / e - e) * period, 0.005 * period);
    EXPECT_NEAR(event.peak_time - event.start, pi / 2 * period, 0.005 * period);
    EXPECT_NEAR(event.peak_normal_force, v * std::sqrt(kMass * kStiffness),
                2e-3 * v * std::sqrt(kMass * kStiffness));
    EXPECT_EQ(event.peak_normal_force, solver.particles().peak_normal_force[0]);
    EXPECT_NEAR(event.normal_impulse, (1 + e) * kMass * v, 2e-3 * kMass * v);
    EXPECT_NEAR(event.impulse.z(), event.normal_impulse, 1e-12 * kMass);
    EXPECT_EQ(event.tangential_impulse, 0);
    EXPECT_NEAR(event.approach_normal, v, 1e-12);
    EXPECT_NEAR(event.approach_tangential, 0, 1e-12);
    EXPECT_NEAR(event.dissipated, 0.5 * kMass * v * v * (1 - e * e), 2e-3 * 0.5 * kMass * v * v);
    EXPECT_LT((event.normal + Vec3::UnitZ()).norm(), 1e-12);
    // The lowest point of the ball, wherever it is in its own axes.
    EXPECT_LT((event.place - Vec3(0.3, 0.2, 0)).norm(), 2e-4);
    EXPECT_LT((turned * event.place_on_a - Vec3(0, 0, -kRadius)).norm(), 2e-4);
    EXPECT_LT((event.place_on_b - event.place).norm(), 1e-12);
  }
}

// Friction that slides all the while takes mu times the normal impulse, across the approach.
TEST(Events, ObliqueImpactHasItsFriction) {
  constexpr double kMu = 0.1, kDown = 0.5, kAlong = 2;
  const Model model = sphere_over_plane(kMu, 0.5);
  Solver solver(model);
  solver.insert(0, {0, 0, kRadius + 1e-5}, Quat::Identity(), {kAlong, 0, -kDown}, Vec3::Zero());
  run_for(solver, 7 * std::sqrt(kMass / kStiffness));
  const std::vector<ContactEvent> events = solver.take_events();
  ASSERT_EQ(events.size(), 1u);
  const ContactEvent& event = events[0];
  EXPECT_NEAR(event.approach_normal, kDown, 1e-12);
  EXPECT_NEAR(event.approach_tangential, kAlong, 1e-12);
  EXPECT_NEAR(event.tangential_impulse, kMu * event.normal_impulse, 0.01 * event.normal_impulse);
  EXPECT_NEAR(event.impulse.x(), -event.tangential_impulse, 1e-12);
  EXPECT_NEAR(event.peak_friction, kMu * event.peak_normal_force, 1e-9 * event.peak_normal_force);
  const Energy energy = solver.energy();
  EXPECT_NEAR(event.dissipated, energy.dissipated_normal + energy.dissipated_friction,
              1e-12 * energy.kinetic);
}

// A ball that bounces is in one contact for the merge time, and in as many as it bounces without.
TEST(Events, ShortGapsAreMerged) {
  for (const double merge : {0.0, 0.5}) {
    Model model = sphere_over_plane(0, 0.8);
    model.gravity = {0, 0, -9.81};
    model.timestep *= 20;
    model.statistics.merge = merge;
    Solver solver(model);
    solver.insert(0, {0, 0, kRadius + 1e-3}, Quat::Identity(), Vec3::Zero(), Vec3::Zero());
    run_for(solver, 0.1);
    std::vector<ContactEvent> events = solver.take_events();
    for (const ContactEvent& event : solver.open_events()) events.push_back(event);
    double impulse = 0;
    for (const ContactEvent& event : events) impulse += event.normal_impulse;
    if (merge > 0) {
      EXPECT_EQ(events.size(), 1u);
    } else {
      // It flies for 2 v / g between two bounces, v falling by 0.8 each time.
      EXPECT_GE(events.size(), 4u);
      EXPECT_NEAR(events[0].approach_normal, std::sqrt(2 * 9.81 * 1e-3), 1e-3);
      for (std::size_t k = 1; k < 4; ++k)
        EXPECT_NEAR(events[k].approach_normal / events[k - 1].approach_normal, 0.8, 0.05);
    }
    const double fallen = kMass * (9.81 * 0.1 + solver.particles().velocity[0].z());
    EXPECT_NEAR(impulse, fallen, 0.01 * fallen);
  }
}

// Crescents that fall into a box of planes.
Model small_box(int crescents, const Vec3& size = {0.14, 0.12, 0}) {
  Model model = scenes::empty(scenes::law(0.1, 0.3), scenes::law(0.3, 0.3));
  scenes::add_particles(model, scenes::add_shape(model, scenes::crescent()), crescents);
  scenes::add_box_of_planes(model, Vec3::Zero(), size);
  model.timestep = 1e-5;
  return model;
}

Solver filled(const Model& model, const Vec3& upper = {0.14, 0.12, 0.3}) {
  Solver solver(model);
  scenes::scatter(solver, 0, static_cast<int>(model.particles.size()), Vec3::Zero(), upper, 3);
  return solver;
}

bool same(const std::vector<ContactEvent>& a, const std::vector<ContactEvent>& b) {
  static_assert(sizeof(ContactEvent) == 8 + 9 * 8 + 5 * 24 + 8 + 8);  // no padding to compare
  return a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), a.size() * sizeof(ContactEvent)) == 0;
}

// All work of all contacts is in one of them, whatever the patches did meanwhile.
TEST(Events, HaveAllTheWorkOfContacts) {
  Model model = small_box(30);
  model.statistics.events = true;
  Solver solver = filled(model);
  scenes::run(solver, 0.4);
  const std::vector<ContactEvent> ended = solver.take_events(), open = solver.open_events();
  ASSERT_GT(ended.size(), 100u);
  ASSERT_GT(open.size(), 20u);
  double work = 0;
  Vec3 impulse = Vec3::Zero();
  for (const auto* events : {&ended, &open}) {
    for (const ContactEvent& e : *events) {
      work += e.dissipated;
      if (e.b >= 30) impulse += e.impulse;
      EXPECT_LE(e.peak_normal_force, solver.particles().peak_normal_force[e.a] * 8);
      EXPECT_GT(e.duration, 0);
      EXPECT_GE(e.peak_time, e.start);
      EXPECT_LE(e.peak_time, e.start + e.duration);
    }
  }
  const Energy energy = solver.energy();
  const double taken = energy.elastic + energy.dissipated_normal + energy.dissipated_friction;
  EXPECT_NEAR(work, taken, 1e-9 * taken);
  Vec3 momentum = Vec3::Zero();
  double mass = 0;
  for (int i = 0; i < 30; ++i) {
    const double m = model.shapes[0].mass;
    momentum += m * solver.particles().velocity[i];
    mass += m;
  }
  momentum -= mass * model.gravity * solver.time();
  // The last half kick has been given with the forces at the end, and the first without any.
  EXPECT_LT((impulse - momentum).norm(), 1e-3 * mass * 9.81 * solver.time());
}

TEST(Events, ChangeNothingOfTheMotion) {
  Model model = small_box(20);
  Solver plain = filled(model);
  model.statistics.events = true;
  Solver counted = filled(model);
  scenes::run(plain, 0.2);
  scenes::run(counted, 0.2);
  const auto a = plain.group_hashes(), b = counted.group_hashes();
  for (std::size_t k = 0; k < a.size(); ++k) {
    if (std::string(a[k].group) != "statistics") {
      EXPECT_EQ(a[k].hash, b[k].hash) << a[k].group;
    }
  }
  EXPECT_TRUE(plain.open_events().empty());
}

TEST(Events, AreTheSameForEveryNumberOfThreadsAndAcrossARestore) {
  Model model = small_box(300, {0.25, 0.2, 0});
  model.statistics.events = true;
  model.statistics.merge = 1e-4;
  model.timestep = 2e-5;
  Solver whole = filled(model, {0.25, 0.2, 0.6});
  scenes::run(whole, 0.2);
  model.numerics.threads = 3;
  Solver shared = filled(model, {0.25, 0.2, 0.6});
  scenes::run(shared, 0.1);
  Solver resumed(model);
  resumed.restore(shared.save());
  scenes::run(shared, 0.1);
  scenes::run(resumed, 0.1);
  ASSERT_GT(whole.health().pairs, 1024u) << "one range of pairs says nothing of threads";
  EXPECT_EQ(whole.hash(), shared.hash());
  EXPECT_EQ(whole.hash(), resumed.hash());
  const std::vector<ContactEvent> events = whole.take_events();
  EXPECT_GT(events.size(), 100u);
  EXPECT_TRUE(same(events, shared.take_events()));
  EXPECT_TRUE(same(events, resumed.take_events()));
  EXPECT_TRUE(same(whole.open_events(), resumed.open_events()));
}

// A body that is taken away ends its contacts.
TEST(Events, EndWhenABodyIsRemoved) {
  Model model = small_box(10);
  model.statistics.events = true;
  model.statistics.threshold = 1e9;
  Solver solver = filled(model);
  scenes::run(solver, 0.3);
  ASSERT_FALSE(solver.open_events().empty());
  EXPECT_TRUE(solver.take_events().empty());  // none reaches the threshold
  for (int i = 0; i < 10; ++i) solver.remove_particle(i);
  solver.step();
  EXPECT_TRUE(solver.open_events().empty());
}

}  // namespace
}  // namespace firn
