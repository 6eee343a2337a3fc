// Motors that stall, and what joints bear.
#include <fmt/format.h>

#include <cmath>

#include "validation/verification/fixtures/closed_forms.h"
#include "validation/verification/fixtures/mechanisms.h"

namespace firn::verification {

namespace {

using namespace scenes;

// A motor with a falling characteristic turns a lever against a stop.
std::vector<Check> motor() {
  constexpr double kStall = 2, kNoLoad = 10, kOwn = 0.01, kRotor = 0.04, kArm = 0.2, kRadius = 0.01;
  constexpr double kInertia = kOwn + kRotor;
  std::vector<Check> checks;
  Model model = mechanism();
  model.gravity.setZero();
  Joint axis = hinge(Vec3::UnitZ());
  axis.armature = kRotor;
  axis.motors.push_back({});
  axis.motors[0].speed = kNoLoad;
  axis.motors[0].max_load = kStall;
  axis.motors[0].no_load_speed = kNoLoad;
  const int frame = add_mover(model, "lever", 1, Vec3::Zero(), Vec3::Constant(kOwn), {axis});
  const int tip = add_ball(model, "tip", {kArm, 0, 0}, kRadius, frame);
  // Met after a quarter of a turn.
  const int stop = add_plane(model, {-kRadius, 0, 0}, Vec3::UnitX());
  model.timestep = 1e-5;
  const double tau = kInertia * kNoLoad / kStall;  // s
  {
    Solver solver(model);
    for (const double time : {0.25, 1.0, 4.0}) {
      run(solver, time * tau - solver.time());
      checks.push_back({fmt::format("speed after {} time constants without load", time),
                        solver.frames()[0].joints[0].rate,
                        kNoLoad * -std::expm1(-solver.time() / tau), 1e-4, Bound::relative,
                        "rad/s"});
    }
  }
  add_contact(model, tip, stop, 0, 0.3, 1e6);
  Solver solver(model);
  run(solver, 4);
  solver.clear_boundary_loads();
  run(solver, 0.1);
  const FrameState now = solver.frames()[0];
  checks.push_back(
      {"speed in stall", std::abs(now.joints[0].rate), 1e-3, 0, Bound::at_most, "rad/s"});
  checks.push_back(
      {"torque in stall", now.joints[0].motor_impulse / 0.1, kStall, 1e-4, Bound::relative, "N m"});
  checks.push_back({"force on the stop in stall, M / r",
                    solver.boundary_contacts()[0].impulse.norm() / 0.1, kStall / kArm, 1e-3,
                    Bound::relative, "N"});
  checks.push_back({"force of the bearing in stall", now.reaction_impulse.norm() / 0.1,
                    kStall / kArm, 1e-3, Bound::relative, "N"});
  return checks;
}

// A pendulum swings from 60 degrees: what its bearing bears.
std::vector<Check> bearing() {
  constexpr double kMass = 0.3, kArm = 0.2, kOwn = 1e-3, kStart = 60 * kDegToRad;
  constexpr double kInertia = kOwn + kMass * kArm * kArm;
  Model model = mechanism();
  const Vec3 center = kArm * Vec3(std::sin(kStart), 0, -std::cos(kStart));
  const int frame =
      add_mover(model, "pendulum", kMass, center, Vec3(2e-3, kOwn, 3e-3), {hinge(-Vec3::UnitY())});
  model.timestep = 1e-5;
  Solver solver(model);
  std::vector<Check> checks;
  for (const double at : {50.0, 20.0, 0.0, -20.0, -50.0}) {
    constexpr int kSteps = 20;
    const auto angle = [&] { return kStart + solver.frames()[frame].joints[0].coordinate; };
    while (angle() > at * kDegToRad) solver.step();
    const double from = solver.time();
    solver.clear_boundary_loads();
    const double first = angle();
    for (int i = 0; i < kSteps; ++i) solver.step();
    const FrameState now = solver.frames()[frame];
    const Vec3 force = now.reaction_impulse / (solver.time() - from);
    const double turn = 0.5 * (first + angle());  // from straight down
    const Vec3 inward(-std::sin(turn), 0, std::cos(turn)),
        across(std::cos(turn), 0, std::sin(turn));
    const double square =
        2 * kMass * kGravity * kArm * (std::cos(turn) - std::cos(kStart)) / kInertia;
    const double acceleration = -kMass * kGravity * kArm * std::sin(turn) / kInertia;
    const std::string scene = fmt::format("at {} degrees: ", at);
    checks.push_back({scene + "force towards the hinge", force.dot(inward),
                      kMass * (kArm * square + kGravity * std::cos(turn)), 1e-4, Bound::relative,
                      "N"});
    checks.push_back({scene + "force across", force.dot(across),
                      kMass * (kArm * acceleration + kGravity * std::sin(turn)), 5e-4,
                      Bound::absolute, "N"});
    checks.push_back({scene + "moment of the free hinge",
                      std::abs(now.reaction_angular_impulse.y()) / (solver.time() - from), 1e-4, 0,
                      Bound::at_most, "N m"});
  }
  return checks;
}

}  // namespace

std::vector<VerificationCase> drive_cases() {
  return {
      {.name = "machine.motor",
       .title = "A motor speeds up and stalls",
       .reference = "w0 (1 - exp(-t M / (J w0))), J with the rotor's own; M / r on the stop",
       .remark = "The torque falls linearly from stall to the speed without load.",
       .run = motor},
      {.name = "machine.bearing",
       .title = "What the bearing of a pendulum bears",
       .reference = "m (r w^2 + g cos a) along the arm, m (r w' + g sin a) across it, no moment "
                    "about the hinge",
       .remark = "From changes of the momenta, means of 20 steps.",
       .run = bearing}};
}

}  // namespace firn::verification
