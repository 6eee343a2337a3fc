// The energies of particles when a body that they touch is removed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "validation/verification/fixtures/bulk_scenes.h"
#include "validation/verification/fixtures/scenes.h"

namespace firn {
namespace {

using scenes::energy_imbalance;
using scenes::kGravity;

constexpr double kBodyMass = 0.01, kBodyRadius = 0.01, kBodyStiffness = 2e4;  // kg, m, N/m

Shape falling_sphere() {
  return make_sphere(kBodyRadius, scenes::ice_options(kBodyMass, kBodyStiffness, kBodyRadius));
}

// J, the largest change of the balance of the particles over some steps.
double largest_change(Solver& solver, int steps) {
  const double start = energy_imbalance(solver.energy());
  double largest = 0;
  for (int k = 0; k < steps; ++k) {
    solver.step();
    largest = std::max(largest, std::abs(energy_imbalance(solver.energy()) - start));
  }
  return largest;
}

// Elastic spheres on each other, each sunk in by the weight that it bears. Only gravity acts in the
// first half of the first step, which their speeds balance.
TEST(RemovedBoundary, AStackAtRestKeepsItsEnergy) {
  constexpr int kSpheres = 3;
  constexpr double kTimestep = 1e-6, kWeight = kBodyMass * kGravity;
  Model model = scenes::empty(scenes::law(0.3, 1), scenes::law(0.3, 1));
  scenes::add_particles(model, scenes::add_shape(model, falling_sphere()), kSpheres);
  const int plate = scenes::add_plane(model, Vec3::Zero(), Vec3::UnitZ());
  model.timestep = kTimestep;
  Solver solver(model);
  double z = -kBodyRadius, total = 0;
  for (int k = 0; k < kSpheres; ++k) {
    const double stiffness = k == 0 ? kBodyStiffness : kBodyStiffness / 2;  // in series
    z += 2 * kBodyRadius - (kSpheres - k) * kWeight / stiffness;
    total += kWeight * z;
    solver.insert(k, {0, 0, z}, Quat::Identity(), {0, 0, 0.5 * kGravity * kTimestep}, Vec3::Zero());
  }
  EXPECT_LT(largest_change(solver, 100), 1e-9 * total);
  const Energy before = solver.energy();
  EXPECT_LT(before.kinetic, 1e-12 * total);
  const double load = kSpheres * kWeight, held = 0.5 * load * load / kBodyStiffness;
  solver.remove_boundary(plate);
  solver.step();
  const Energy after = solver.energy();
  EXPECT_NEAR(energy_imbalance(after), energy_imbalance(before), 1e-9 * total);
  // The plate's contact loses what it holds; the others still hold the same.
  EXPECT_NEAR(before.elastic - after.elastic, held, 1e-3 * held);
  EXPECT_NEAR(after.dissipated_normal - before.dissipated_normal, held, 1e-3 * held);
  EXPECT_NEAR(after.dissipated_boundaries - before.dissipated_boundaries, held, 1e-3 * held);
  EXPECT_LT(largest_change(solver, 500), 1e-9 * total);
}

// A body that strikes a plane at z = 0 obliquely and spins, with all parts of the contact law.
struct StrikingBody {
  std::string name;
  Shape shape;
  Quat orientation = Quat::Identity();
  double height = 0;  // m, of its center when it touches
};
std::vector<StrikingBody> striking_bodies() {
  const Shape cube = make_box(Vec3::Constant(2 * kBodyRadius),
                              scenes::ice_options(kBodyMass, kBodyStiffness, 5e-4));
  const Quat turn(Eigen::AngleAxisd(0.4, Vec3(1, 2, 0.5).normalized()));
  const double edge = 5e-4, reach = turn.toRotationMatrix().row(2).cwiseAbs().sum();
  return {{"sphere", falling_sphere(), Quat::Identity(), kBodyRadius},
          {"flat cube", cube, Quat::Identity(), kBodyRadius},
          {"corner of a cube", cube, turn, edge + (kBodyRadius - edge) * reach}};
}
Model struck_plane(const Shape& shape) {
  Interaction law = scenes::law(0.3, 0.6);
  law.rolling_resistance = 0.05;
  law.adhesion_force = 0.02;
  law.adhesion_stiffness_fraction = 0.05;
  Model model = scenes::body_on_plane(shape, law);
  model.timestep = 2e-6;
  return model;
}

// The contact takes half a step's work of its last load, and loses what it holds.
TEST(RemovedBoundary, TakesHalfAStepsWorkOfItsLastLoad) {
  for (const StrikingBody& body : striking_bodies()) {
    SCOPED_TRACE(body.name);
    Model model = struck_plane(body.shape);
    model.statistics.events = true;
    Solver solver(model);
    solver.insert(0, {0, 0, body.height + 1e-7}, body.orientation, {0.1, 0.05, -0.3}, {2, 3, 1});
    scenes::run(solver, 2e-4);
    const Energy before = solver.energy();
    const std::vector<Contact> contacts = solver.contacts();
    ASSERT_FALSE(contacts.empty());
    double power = 0;  // W, on the body
    for (const Contact& c : contacts)
      power += c.force.dot(solver.particles().velocity[0]) +
               c.moment_a.dot(solver.particles().angular_velocity[0]);
    const double lost = -0.5 * model.timestep * power;
    EXPECT_GT(before.elastic, 0);
    EXPECT_GT(lost, 1e-8);
    solver.remove_boundary(0);
    solver.step();
    const Energy after = solver.energy();
    EXPECT_EQ(after.elastic, 0);
    EXPECT_NEAR(energy_imbalance(after), energy_imbalance(before), 0.02 * lost);
    const double dissipated = after.dissipated_normal + after.dissipated_friction,
                 dissipated_before = before.dissipated_normal + before.dissipated_friction;
    EXPECT_NEAR(dissipated - dissipated_before, before.elastic + lost, 0.02 * lost);
    EXPECT_NEAR(after.dissipated_boundaries, dissipated, 1e-9 * dissipated);
    EXPECT_LT(largest_change(solver, 500), 0.02 * lost);
    // The list of contacts has all of their work.
    double listed = 0;
    for (const ContactEvent& event : solver.take_events()) listed += event.dissipated;
    for (const ContactEvent& event : solver.open_events()) listed += event.dissipated;
    EXPECT_NEAR(listed, dissipated, 1e-9 * dissipated);
  }
}

// Two bodies meet, and one of them is removed while they touch: the first or the second.
TEST(RemovedParticle, TakesHalfAStepsWorkOfItsLastLoad) {
  for (const StrikingBody& body : striking_bodies()) {
    for (const int removed : {0, 1}) {
      SCOPED_TRACE(testing::Message() << body.name << ", removed " << removed);
      Interaction law = scenes::law(0.3, 0.6);
      law.rolling_resistance = 0.05;
      Model model = scenes::empty(law, law);
      const Shape table = make_box(Vec3(0.06, 0.06, 0.02), scenes::ice_options(0.05, 2e4, 5e-4));
      scenes::add_particles(model, scenes::add_shape(model, table), 1);
      scenes::add_particles(model, scenes::add_shape(model, body.shape), 1);
      model.timestep = 2e-6;
      model.statistics.events = true;
      Solver solver(model);
      solver.insert(0, {0, 0, -0.01}, Quat::Identity(), {-0.1, 0, 0.1}, {0.5, -1, 2});
      solver.insert(1, {0, 0, body.height + 1e-6}, body.orientation, {0.1, 0.05, -0.3}, {2, 3, 1});
      scenes::run(solver, 2e-4);
      const Energy before = solver.energy();
      const std::vector<Contact> contacts = solver.contacts();
      ASSERT_FALSE(contacts.empty());
      const int partner = 1 - removed;
      double power = 0;  // W, on the partner
      for (const Contact& c : contacts) {
        const double sign = c.a == partner ? 1 : -1;
        power += sign * c.force.dot(solver.particles().velocity[index(partner)]) +
                 (c.a == partner ? c.moment_a : c.moment_b)
                     .dot(solver.particles().angular_velocity[index(partner)]);
      }
      const double lost = -0.5 * model.timestep * power;
      EXPECT_GT(std::abs(lost), 1e-9);
      solver.remove_particle(removed);
      EXPECT_NEAR(energy_imbalance(solver.energy()), energy_imbalance(before), 1e-12);
      solver.step();
      const Energy after = solver.energy();
      EXPECT_EQ(after.elastic, 0);
      EXPECT_NEAR(energy_imbalance(after), energy_imbalance(before), 0.03 * std::abs(lost));
      const double dissipated = after.dissipated_normal + after.dissipated_friction,
                   dissipated_before = before.dissipated_normal + before.dissipated_friction;
      EXPECT_NEAR(dissipated - dissipated_before, before.elastic + lost, 0.03 * std::abs(lost));
      EXPECT_EQ(after.dissipated_boundaries, 0);
      double listed = 0;
      for (const ContactEvent& event : solver.take_events()) listed += event.dissipated;
      for (const ContactEvent& event : solver.open_events()) listed += event.dissipated;
      EXPECT_NEAR(listed, dissipated, 1e-9 * dissipated);
    }
  }
}

// The work of a plane that moves at a constant speed is complete once its contact has ended.
TEST(RemovedBoundary, ThatMovesHasDoneItsWork) {
  Model model = scenes::body_on_plane(falling_sphere(), scenes::law(0, 0.6));
  model.timestep = 2e-6;
  Motion up;
  up.velocity = {0, 0, 0.2};
  model.boundaries[0].motions = {up};
  Solver solver(model);
  solver.insert(0, {0, 0, kBodyRadius + 1e-6}, Quat::Identity(), {0, 0, -0.1}, Vec3::Zero());
  const double start = energy_imbalance(solver.energy());
  scenes::run(solver, 2e-4);
  const std::vector<Contact> contacts = solver.contacts();
  ASSERT_EQ(contacts.size(), 1u);
  const double closing = up.velocity.z() - solver.particles().velocity[0].z(),
               lost = 0.5 * model.timestep * contacts[0].force.z() * closing;
  EXPECT_GT(lost, 1e-7);
  solver.remove_boundary(0);
  solver.step();
  EXPECT_NEAR(energy_imbalance(solver.energy()), start, 0.02 * lost);
}

// What the plane still did to the particle in the last step counts as dissipated.
TEST(RemovedParticle, FromAMovingPlaneLeavesTheWorkOfThePlane) {
  for (const StrikingBody& body : striking_bodies()) {
    SCOPED_TRACE(body.name);
    Model model = struck_plane(body.shape);
    model.statistics.events = true;
    Motion up, turn;
    up.velocity = {0.05, -0.1, 0.2};
    turn.kind = Motion::Kind::rotation;
    turn.axis = Vec3(1, -2, 3).normalized();
    turn.angular_speed = 4;
    model.boundaries[0].motions = {up, turn};
    Solver solver(model);
    solver.insert(0, {0, 0, body.height + 1e-6}, body.orientation, {0.1, 0.05, -0.2}, {2, 3, 1});
    const double start = energy_imbalance(solver.energy());
    scenes::run(solver, 2e-4);
    double power = 0;  // W, of the plane
    const BoundaryState& plane = solver.boundaries()[0];
    for (const Contact& c : solver.contacts()) {
      const Vec3 at = plane.velocity +
                      plane.angular_velocity.cross(solver.particles().position[0] - plane.position);
      power += c.force.dot(at) + c.moment_a.dot(plane.angular_velocity);
    }
    const double given = 0.5 * model.timestep * power;
    EXPECT_GT(std::abs(given), 1e-8);
    const Energy before = solver.energy();
    EXPECT_NEAR(energy_imbalance(before) + given, start, 0.1 * std::abs(given));
    solver.remove_particle(0);
    solver.step();
    const Energy after = solver.energy();
    EXPECT_NEAR(energy_imbalance(after), start, 0.03 * std::abs(given));
    EXPECT_NEAR(after.dissipated_boundaries - before.dissipated_boundaries, before.elastic + given,
                0.03 * std::abs(given));
    double listed = 0;
    for (const ContactEvent& event : solver.take_events()) listed += event.dissipated;
    for (const ContactEvent& event : solver.open_events()) listed += event.dissipated;
    EXPECT_NEAR(listed, after.dissipated_boundaries, 1e-9 * std::abs(listed));
  }
}

// A state that is saved between the removal and the next step leads to the same bits.
TEST(RemovedBoundary, IsKeptInAState) {
  const StrikingBody body = striking_bodies()[2];
  const Model model = struck_plane(body.shape);
  Solver solver(model), restored(model);
  solver.insert(0, {0, 0, body.height + 1e-7}, body.orientation, {0.1, 0.05, -0.3}, {2, 3, 1});
  scenes::run(solver, 2e-4);
  solver.remove_boundary(0);
  restored.restore(solver.save());
  solver.step();
  restored.step();
  EXPECT_EQ(restored.hash(), solver.hash());
}

}  // namespace
}  // namespace firn
