// The energy account of free bodies and of the contacts between boundaries.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "validation/verification/fixtures/mechanisms.h"

namespace firn {
namespace {

using scenes::add_mover;
using scenes::hinge;
using scenes::kGravity;
using scenes::slider;

// J, the largest change of the balance over a duration (s), at ends of steps.
double imbalance(Solver& solver, double duration) {
  const double start = solver.energy().free_bodies.balance();
  double largest = 0;
  for (long k = std::lround(duration / solver.model().timestep); k > 0; --k) {
    solver.step();
    if (k % 5 != 0) continue;
    const double now = solver.energy().free_bodies.balance();
    largest = std::max(largest, std::abs(now - start));
  }
  return largest;
}

// A slider-crank with springs, dampers and friction in its joints, friction in its coupling, and a
// motor on the crank.
Model any_linkage(std::mt19937& random) {
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution(low, high)(random);
  };
  Model model = scenes::mechanism();
  const double r = between(0.02, 0.05), l = between(0.12, 0.2), height = between(-0.03, 0.03);
  const Vec3 end(r, 0, 0), wrist(r + std::sqrt(l * l - height * height), 0, height);
  const int crank = scenes::add_bar(model, between(0.1, 0.3), Vec3::Zero(), end, -1),
            rod = scenes::add_bar(model, between(0.1, 0.3), end, wrist, crank),
            piston = add_mover(model, "piston", between(0.2, 0.5), wrist, Vec3::Constant(1e-4),
                               {slider(Vec3::UnitX())}, wrist);
  for (MotionFrame& frame : model.frames) {
    Joint& joint = frame.free->joints[0];
    const bool turns = joint.kind == Joint::Kind::rotation;
    joint.friction = turns ? between(0, 1e-3) : between(0, 0.1);
    joint.friction_coefficient = between(0, 0.2);
    joint.bearing_radius = turns ? between(2e-3, 5e-3) : 0;
    joint.damping = turns ? between(0, 1e-3) : between(0, 1);
    joint.armature = turns ? between(0, 1e-4) : between(0, 0.1);
  }
  model.frames[static_cast<std::size_t>(piston)].free->joints[0].stiffness = between(10, 50);
  Coupling pin = scenes::pin(rod, piston, wrist);
  pin.direction = Vec3::UnitY();
  pin.friction_coefficient = between(0.05, 0.3);
  pin.bearing_radius = between(2e-3, 5e-3);
  model.couplings = {pin};
  Motor motor;
  motor.speed = motor.no_load_speed = between(15, 30);
  motor.max_load = between(0.3, 0.6);
  model.frames[static_cast<std::size_t>(crank)].free->joints[0].motors = {motor};
  return model;
}

TEST(FreeBodyEnergy, OfALinkageBalancesToSecondOrderInTheStep) {
  std::mt19937 random(23);
  double coarse = 0, fine = 0;  // over what was turned over
  for (int member = 0; member < 4; ++member) {
    Model model = any_linkage(random);
    for (double* worst : {&coarse, &fine}) {
      model.timestep = worst == &coarse ? 4e-4 : 1e-4;
      Solver solver(model);
      const double error = imbalance(solver, 0.6);
      const FreeBodyEnergy e = solver.energy().free_bodies;
      EXPECT_GT(e.dissipated_friction, 1e-3);
      EXPECT_GT(e.dissipated_damping, 1e-4);
      EXPECT_GT(e.work, 0.01);
      *worst = std::max(*worst, error / e.work);
    }
  }
  EXPECT_LT(fine, 1e-3);
  EXPECT_GT(coarse, 6 * fine);  // 16 by the order
}

TEST(FreeBodyEnergy, DampersTakeWhatAnOscillatorLoses) {
  Joint axis = slider(Vec3::UnitX());
  axis.stiffness = 50;
  axis.damping = 0.8;
  axis.spring_reference = 0.1;
  Model model = scenes::mechanism();
  add_mover(model, "slide", 0.5, Vec3::Zero(), Vec3::Ones(), {axis});
  model.timestep = 1e-4;
  Solver solver(model);
  const double held = 0.5 * 50 * 0.1 * 0.1;  // J
  EXPECT_LT(imbalance(solver, 5), 1e-5 * held);
  const FreeBodyEnergy e = solver.energy().free_bodies;
  // Its amplitude decays by exp(-c t / (2 m)).
  EXPECT_NEAR(e.dissipated_damping, held * (1 - std::exp(-0.8 * 5 / 0.5)), 0.01 * held);
  EXPECT_EQ(e.dissipated_friction, 0);
  EXPECT_EQ(e.work, 0);
}

TEST(FreeBodyEnergy, LimitsTakeWhatTheirRestitutionLeaves) {
  constexpr double kMass = 0.5, kHeight = 0.05, kRestitution = 0.4;
  Joint axis = slider(Vec3::UnitZ());
  axis.lower = -kHeight;
  axis.limit_restitution = kRestitution;
  Model model = scenes::mechanism();
  add_mover(model, "slide", kMass, Vec3::Zero(), Vec3::Ones(), {axis});
  model.timestep = 1e-5;
  Solver solver(model);
  const double fall = kMass * kGravity * kHeight;
  EXPECT_LT(imbalance(solver, 0.12), 1e-3 * fall);  // one impact, at 0.101 s
  EXPECT_NEAR(solver.energy().free_bodies.dissipated_damping,
              fall * (1 - kRestitution * kRestitution), 1e-3 * fall);
  scenes::run(solver, 1);  // on the limit
  EXPECT_NEAR(solver.energy().free_bodies.dissipated_damping, fall, 1e-2 * fall);
}

TEST(FreeBodyEnergy, StickingFrictionAndAHeldLoadDissipateNothing) {
  Joint axis = slider(Vec3::UnitZ());
  axis.friction = 1.5 * 0.5 * kGravity;
  Model model = scenes::mechanism();
  add_mover(model, "slide", 0.5, Vec3::Zero(), Vec3::Ones(), {axis});
  model.timestep = 1e-4;
  Solver solver(model);
  EXPECT_EQ(imbalance(solver, 0.1), 0);
  EXPECT_EQ(solver.energy().free_bodies.dissipated_friction, 0);
}

// A box that lies on a belt.
struct BoxOnBelt {
  double mass = 2, speed = 0.5;  // kg, m/s
  Model model = scenes::mechanism();
  int belt, load;  // boundaries

  BoxOnBelt() {
    constexpr double kStiffness = 1e6;
    const int box = add_mover(model, "box", mass, {0, 0, 0.05}, Vec3::Constant(0.01),
                              {slider(Vec3::UnitX()), slider(Vec3::UnitZ())});
    belt = scenes::add_panel(model, "belt", {-1, -0.2, -0.1}, {1, 0.2, 0});
    const double dent = mass * kGravity / kStiffness;
    load = scenes::add_panel(model, "load", {-0.05, -0.05, -dent}, {0.05, 0.05, 0.1 - dent});
    Motion along;
    along.velocity = {speed, 0, 0};
    model.boundaries[index(belt)].motions = {along};
    model.boundaries[index(load)].frame = box;
    scenes::add_contact(model, load, belt, 0.3, 0.5, kStiffness);
    model.timestep = 2e-5;
  }
};

// A belt takes a box along: half of its work is lost in the contact.
TEST(FreeBodyEnergy, AMovingBoundaryWorksThroughItsContact) {
  const BoxOnBelt scene;
  Solver solver(scene.model);
  const double given = scene.mass * scene.speed * scene.speed;
  EXPECT_LT(imbalance(solver, 0.4), 2e-3 * given);
  const FreeBodyEnergy e = solver.energy().free_bodies;
  EXPECT_NEAR(e.work, given, 0.02 * given);
  EXPECT_NEAR(e.dissipated_contacts, 0.5 * given, 0.02 * given);
}

// The box slips on the belt when the belt or the boundary of the box is removed. The contact loses
// what it holds, and half a step's work of its last load.
TEST(FreeBodyEnergy, BalancesWhenATouchingBoundaryIsRemoved) {
  const BoxOnBelt scene;
  for (const int removed : {scene.belt, scene.load}) {
    Solver solver(scene.model);
    scenes::run(solver, 0.05);
    const FreeBodyEnergy before = solver.energy().free_bodies;
    const double slip = scene.speed - solver.frames()[0].joints[0].rate,
                 friction = solver.boundary_contacts()[0].force.x(),
                 lost = 0.5 * scene.model.timestep * friction * slip;
    EXPECT_GT(before.contacts_elastic, 0);
    EXPECT_GT(lost, 1e-5);
    solver.remove_boundary(removed);
    solver.step();
    const FreeBodyEnergy after = solver.energy().free_bodies;
    EXPECT_EQ(after.contacts_elastic, 0);
    EXPECT_NEAR(after.dissipated_contacts - before.dissipated_contacts,
                before.contacts_elastic + lost, 0.02 * lost);
    EXPECT_NEAR(after.balance(), before.balance(), 0.02 * lost);
    EXPECT_LT(imbalance(solver, 0.05), 0.02 * lost);
  }
}

TEST(FreeBodyEnergy, AHammerThatStrikesAWallBalances) {
  for (const double restitution : {0.9, 0.4}) {
    Model model = scenes::mechanism();
    const int frame =
        add_mover(model, "hammer", 0.4, {0, 0, -0.2}, Vec3::Constant(2e-3), {hinge(Vec3::UnitY())});
    const int head = scenes::add_ball(model, "head", {0, 0, -0.3}, 0.02, frame);
    const int wall = scenes::add_plane(model, {-0.02, 0, 0}, Vec3::UnitX());
    scenes::add_contact(model, head, wall, 0.2, restitution, 1e5);
    model.timestep = 1e-5;
    Solver solver(model);
    scenes::start_mover(solver, frame, {-0.02}, {3});
    const double kinetic = solver.energy().free_bodies.kinetic;
    EXPECT_NEAR(kinetic, 0.5 * (2e-3 + 0.4 * 0.04) * 9, 1e-12);
    EXPECT_LT(imbalance(solver, 0.03), 1e-3 * kinetic);
    const FreeBodyEnergy e = solver.energy().free_bodies;
    EXPECT_GT(e.dissipated_contacts, 0.5 * (1 - restitution * restitution) * kinetic);
    EXPECT_NEAR(e.contacts_elastic, 0, 1e-9 * kinetic);
  }
}

// What a particle gives a slide is the work on it.
TEST(FreeBodyEnergy, ParticlesWorkOnABodyThatTheyHit) {
  constexpr double kSpeed = 0.5;
  Model model = scenes::empty(scenes::law(0, 0.3), scenes::law(0, 0.3));
  model.gravity.setZero();
  scenes::add_particles(
      model, scenes::add_shape(
                 model, make_box(Vec3::Constant(0.02), scenes::ice_options(0.02, 2e4, 5e-4))));
  const int slide =
      add_mover(model, "slide", 0.05, Vec3::Zero(), Vec3::Ones(), {slider(Vec3::UnitX())});
  const int plate = scenes::add_panel(model, "plate", {-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1});
  model.boundaries[index(plate)].frame = slide;
  model.timestep = 2e-6;
  Solver solver(model);
  solver.insert(0, {-0.115, 0, 0}, Quat::Identity(), {kSpeed, 0, 0}, Vec3::Zero());
  scenes::run(solver, 0.03);
  const FreeBodyEnergy e = solver.energy().free_bodies;
  EXPECT_GT(e.kinetic, 1e-4);
  EXPECT_NEAR(e.work, e.kinetic, 1e-7 * e.kinetic);
}

// A slide on a guide that starts to turn at once, with its jolt, and without gravity.
TEST(FreeBodyEnergy, AMovingCarrierWorksThroughItsJoints) {
  constexpr double kMass = 0.5, kSpeed = 6, kStart = 0.1;
  for (const bool as_mechanism : {false, true}) {
    Model model = scenes::mechanism();
    model.gravity.setZero();
    const int slide = scenes::add_slide_on_turning_table(model, kSpeed, kStart, 0.2);
    if (as_mechanism) {
      const Vec3 place(kStart, 0, 0);
      const int wheel = add_mover(model, "wheel", 0.1, place, Vec3::Constant(1e-5),
                                  {hinge(Vec3::UnitZ())}, place);
      model.frames[index(wheel)].parent = slide;
    }
    model.timestep = 1e-4;
    Solver solver(model);
    scenes::start_mover(solver, slide, {0}, {0.5});
    const double error = imbalance(solver, 0.2);
    const FreeBodyEnergy e = solver.energy().free_bodies;
    EXPECT_GT(e.work, 0.5 * kMass * kStart * kStart * kSpeed * kSpeed);
    EXPECT_GT(e.dissipated_friction, 0.01 * e.work);
    EXPECT_LT(error, 5e-3 * e.work);
  }
}

TEST(FreeBodyEnergy, IsKeptInAState) {
  std::mt19937 random(31);
  Model model = any_linkage(random);
  model.timestep = 1e-4;
  Solver whole(model), first(model), second(model);
  scenes::run(whole, 0.2);
  scenes::run(first, 0.1);
  second.restore(first.save());
  scenes::run(second, 0.1);
  const FreeBodyEnergy a = whole.energy().free_bodies, b = second.energy().free_bodies;
  EXPECT_EQ(a.work, b.work);
  EXPECT_EQ(a.dissipated_friction, b.dissipated_friction);
  EXPECT_EQ(a.dissipated_damping, b.dissipated_damping);
  EXPECT_EQ(a.balance(), b.balance());
}

}  // namespace
}  // namespace firn
