// Motors that stall, stick-slip, and what joints bear.
#include <fmt/format.h>

#include <algorithm>
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

// Friction of bearings that follows what they bear.
constexpr double kBearingStep = 1e-4;  // s

// A wheel whose center is `overhang` from the middle of its bearing, along the axle, slows down.
void add_wheel(double overhang, std::vector<Check>& checks) {
  constexpr double kMass = 2, kInertia = 4e-3, kRate = 30, kFriction = 0.25, kRadius = 0.01;
  constexpr double kLength = 0.1;
  Model model = mechanism();
  Joint axle = hinge(Vec3::UnitX());
  axle.friction_coefficient = kFriction;
  axle.bearing_radius = kRadius;
  axle.bearing_length = kLength;
  add_mover(model, "wheel", kMass, {overhang, 0, 0}, Vec3(kInertia, kInertia, kInertia), {axle});
  model.timestep = kBearingStep;
  Solver solver(model);
  start_mover(solver, 0, {0}, {kRate});
  run(solver, 5);
  const FrameState::JointState now = solver.frames()[0].joints[0];
  const double borne = kMass * kGravity * std::max(1.0, 2 * overhang / kLength);
  const std::string scene = fmt::format("wheel {} mm off the middle: ", 1000 * overhang);
  checks.push_back({scene + "angle to rest", now.coordinate,
                    kInertia * kRate * kRate / (2 * kFriction * kRadius * borne), 1e-3,
                    Bound::relative, "rad"});
  checks.push_back({scene + "speed at rest", std::abs(now.rate), 0, 0, Bound::absolute, "rad/s"});
}

// A slide starts down a slope.
void add_slide(double slope, double friction, std::vector<Check>& checks) {
  constexpr double kSpeed = 1, kTime = 0.5;
  Model model = mechanism();
  Joint guide = slider({std::cos(slope), 0, -std::sin(slope)});
  guide.friction_coefficient = friction;
  add_mover(model, "slide", 0.7, Vec3::Zero(), Vec3::Constant(1e-3), {guide});
  model.timestep = kBearingStep;
  Solver solver(model);
  start_mover(solver, 0, {0}, {kSpeed});
  run(solver, kTime);
  const double a = kGravity * (std::sin(slope) - friction * std::cos(slope));
  const double until = a < 0 ? std::min(kTime, -kSpeed / a) : kTime;
  checks.push_back(
      {fmt::format("slope of {:.0f} degrees, friction {}: distance", slope / kDegToRad, friction),
       solver.frames()[0].joints[0].coordinate, kSpeed * until + 0.5 * a * until * until, 1e-3,
       Bound::relative, "m"});
}

// A bracket on a vertical guide, its center at a lateral offset. It locks itself from a ratio of
// 2 mu e / L = 1 on.
double bracket_falls(double ratio, double time) {
  constexpr double kFriction = 0.2, kLength = 0.05;
  Model model = mechanism();
  Joint guide = slider(-Vec3::UnitZ());
  guide.friction_coefficient = kFriction;
  guide.bearing_length = kLength;
  add_mover(model, "bracket", 0.4, {ratio * kLength / (2 * kFriction), 0, 0}, Vec3::Constant(1e-3),
            {guide});
  model.timestep = kBearingStep;
  Solver solver(model);
  run(solver, time);
  return solver.frames()[0].joints[0].coordinate;
}

// A cart with a wheel on it, a mechanism of two bodies, brakes by the friction of its guide.
void add_cart(std::vector<Check>& checks) {
  constexpr double kCart = 1.5, kWheel = 0.8, kInertia = 2e-3, kGuide = 0.15, kAxle = 0.3,
                   kRadius = 0.006, kSpeed = 1.2, kRate = 5;
  Model model = mechanism();
  Joint guide = slider(Vec3::UnitX()), axle = hinge(Vec3::UnitY());
  guide.friction_coefficient = kGuide;
  axle.friction_coefficient = kAxle;
  axle.bearing_radius = kRadius;
  const int cart = add_mover(model, "cart", kCart, Vec3::Zero(), Vec3::Constant(0.01), {guide});
  const Vec3 hub(0.05, 0, 0.1);
  const int wheel = add_mover(model, "wheel", kWheel, hub, Vec3::Constant(kInertia), {axle}, hub);
  model.frames[static_cast<std::size_t>(wheel)].parent = cart;
  model.timestep = kBearingStep;
  Solver solver(model);
  start_mover(solver, cart, {0}, {kSpeed});
  start_mover(solver, wheel, {0}, {kRate});
  run(solver, 1.5);
  const double braking = kGuide * kGravity;
  checks.push_back({"cart: distance to rest", solver.frames()[0].joints[0].coordinate,
                    kSpeed * kSpeed / (2 * braking), 1e-3, Bound::relative, "m"});
  checks.push_back(
      {"wheel on the cart: angle to rest", solver.frames()[1].joints[0].coordinate,
       kInertia * kRate * kRate / (2 * kAxle * kRadius * kWheel * std::hypot(kGravity, braking)),
       1e-3, Bound::relative, "rad"});
}

// A slide on a radial guide that turns about a vertical axis without gravity: r'' = w^2 r - 2 mu w
// r'.
void add_turning_guide(double friction, std::vector<Check>& checks) {
  constexpr double kSpeed = 6, kStart = 0.1, kTime = 0.3;
  Model model = mechanism();
  model.gravity.setZero();
  const int slide = add_slide_on_turning_table(model, kSpeed, kStart, friction);
  model.timestep = kBearingStep;
  Solver solver(model);
  const double growth = kSpeed * (std::sqrt(1 + friction * friction) - friction);  // 1/s
  start_mover(solver, slide, {0}, {growth * kStart});
  run(solver, kTime);
  checks.push_back({fmt::format("turning guide, friction {}: distance", friction),
                    kStart + solver.frames()[static_cast<std::size_t>(slide)].joints[0].coordinate,
                    kStart * std::exp(growth * kTime), 2e-3, Bound::relative, "m"});
}

std::vector<Check> bearing_friction() {
  std::vector<Check> checks;
  for (const double overhang : {0.0, 0.03, 0.08}) add_wheel(overhang, checks);
  add_slide(10 * kDegToRad, 0.5, checks);
  add_slide(30 * kDegToRad, 0.2, checks);
  add_slide(0, 0.3, checks);
  constexpr double kTime = 0.2;
  for (const double ratio : {1.02, 3.0})
    checks.push_back({fmt::format("bracket with 2 mu e / L = {}: fall", ratio),
                      bracket_falls(ratio, kTime), 0, 0, Bound::absolute, "m"});
  for (const double ratio : {0.3, 0.9})
    checks.push_back({fmt::format("bracket with 2 mu e / L = {}: fall", ratio),
                      bracket_falls(ratio, kTime), 0.5 * kGravity * kTime * kTime, 0.02,
                      Bound::relative, "m"});
  add_cart(checks);
  for (const double friction : {0.0, 0.2, 0.7}) add_turning_guide(friction, checks);
  return checks;
}

// A rod on a spring lies on a guide that moves: it sticks, slips back, and sticks again.
struct StickSlip {
  double static_friction, dynamic_friction, speed;  // m/s, of the guide
  double mass = 1, stiffness = 100, damping = 4;    // kg, N/m, N s/m, of the rod's joint
};

struct Cycle {
  double period = 0, farthest = 0, nearest = 0, heat = 0;  // s, m, m, J
};

// Closed form: the rod is released with the guide's speed where spring and damper reach static
// friction, swings as a damped oscillator about the deflection of dynamic friction, and is caught
// where it has the guide's speed again. The damping must let it reach that speed.
Cycle exact_cycle(const StickSlip& s) {
  const double weight = s.mass * kGravity;
  const double middle = s.dynamic_friction * weight / s.stiffness;
  const double release = (s.static_friction * weight - s.damping * s.speed) / s.stiffness;
  const double decay = s.damping / (2 * s.mass);
  const double frequency = std::sqrt(s.stiffness / s.mass - decay * decay);
  const double cosine = release - middle, sine = (s.speed + decay * cosine) / frequency;
  const auto deflection = [&](double t) {
    return std::exp(-decay * t) *
           (cosine * std::cos(frequency * t) + sine * std::sin(frequency * t));
  };
  const auto speed = [&](double t) {
    return std::exp(-decay * t) *
               (frequency * (sine * std::cos(frequency * t) - cosine * std::sin(frequency * t))) -
           decay * deflection(t);
  };
  const auto crossing = [&](double from, double level, double sign) {
    constexpr double kStep = 1e-5;
    double t = from;
    while (sign * (speed(t + kStep) - level) < 0) t += kStep;
    return t + kStep * (level - speed(t)) / (speed(t + kStep) - speed(t));
  };
  const double turn = crossing(0, 0, -1);
  const double back = crossing(turn + 1e-3, 0, 1), caught = crossing(back, s.speed, 1);
  const double end = middle + deflection(caught);
  Cycle c;
  c.period = caught + (release - end) / s.speed;
  c.farthest = middle + deflection(turn);
  c.nearest = middle + deflection(back);
  c.heat = s.dynamic_friction * weight * (s.speed * caught - (end - release));
  return c;
}

Cycle simulated_cycle(const StickSlip& s) {
  Model model = mechanism();
  Joint along = slider(Vec3::UnitX());
  along.stiffness = s.stiffness;
  along.damping = s.damping;
  Joint up = slider(Vec3::UnitZ());
  up.damping = 200;  // ends the bouncing of the start
  const int rod = add_mover(model, "rod", s.mass, {0, 0, 0.05}, Vec3::Constant(0.01), {along, up});
  const int guide =
      add_mover(model, "guide", 1, {0, 0, -0.05}, Vec3::Constant(0.01), {slider(Vec3::UnitX())});
  drive_at(model, guide, s.speed);
  const int bed = add_panel(model, "bed", {-1, -0.2, -0.1}, {1, 0.2, 0});
  constexpr double kStiffness = 1e6;
  const double dent = s.mass * kGravity / kStiffness;
  const int load = add_panel(model, "load", {-0.05, -0.05, -dent}, {0.05, 0.05, 0.1 - dent});
  model.boundaries[bed].frame = guide;
  model.boundaries[load].frame = rod;
  add_contact(model, load, bed, s.static_friction, 0.5, kStiffness);
  model.boundary_contacts.back().law.dynamic_friction = s.dynamic_friction;
  model.timestep = 1e-4;
  Solver solver(model);
  Cycle c;
  double before = 0, rate_before = 0, last_turn = 0, last_heat = 0, nearest = 0;
  int turns = 0;
  // The second turn to the third: the first cycle starts from the undeflected spring.
  while (turns < 3 && solver.time() < 60) {
    solver.step();
    const FrameState::JointState now = solver.frames()[0].joints[0];
    if (rate_before > 0 && now.rate <= 0 && before > 0.5 * c.farthest) {
      ++turns;
      const double heat = solver.boundary_contacts()[0].dissipated_friction;
      c = {solver.time() - last_turn, std::max(before, now.coordinate), nearest, heat - last_heat};
      last_turn = solver.time();
      last_heat = heat;
      nearest = now.coordinate;
    }
    nearest = std::min(nearest, now.coordinate);
    before = now.coordinate;
    rate_before = now.rate;
  }
  return c;
}

std::vector<Check> stick_slip() {
  std::vector<Check> checks;
  for (const StickSlip& s : {StickSlip{0.5, 0.3, 0.01}, StickSlip{0.5, 0.3, 0.007},
                             StickSlip{0.6, 0.1, 0.02}, StickSlip{0.4, 0.3, 0.004}}) {
    const Cycle cycle = simulated_cycle(s), exact = exact_cycle(s);
    const std::string scene =
        fmt::format("friction {} and {}, {} m/s: ", s.static_friction, s.dynamic_friction, s.speed);
    checks.push_back({scene + "period", cycle.period, exact.period, 1e-3, Bound::relative, "s"});
    checks.push_back(
        {scene + "farthest", cycle.farthest, exact.farthest, 1e-3, Bound::relative, "m"});
    checks.push_back({scene + "nearest", cycle.nearest, exact.nearest, 1e-3, Bound::relative, "m"});
    checks.push_back({scene + "heat by friction in a cycle", cycle.heat, exact.heat, 1e-3,
                      Bound::relative, "J"});
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
      {.name = "machine.stick_slip",
       .title = "A rod on a spring sticks to a moving guide and slips",
       .reference = "damped oscillator about mu_d m g / k, released where k x + c v = mu_s m g, "
                    "caught at the guide's speed",
       .remark = "The damper ends the ringing on the springs of the contact while the rod sticks.",
       .run = stick_slip},
      {.name = "machine.bearing",
       .title = "What the bearing of a pendulum bears",
       .reference = "m (r w^2 + g cos a) along the arm, m (r w' + g sin a) across it, no moment "
                    "about the hinge",
       .remark = "From changes of the momenta, means of 20 steps.",
       .run = bearing},
      {.name = "machine.bearing_friction",
       .title = "Friction of bearings that follows their load",
       .reference =
           "torque mu r m g max(1, 2 s / L) with the center s from the middle; a slide's "
           "g (sin a - mu cos a); a bracket locks where 2 mu e / L >= 1, else falls freely; "
           "r'' = w^2 r - 2 mu w r' on a guide that turns",
       .remark = "The load is that of the step before: a bracket below the limit is let go within "
                 "some steps.",
       .run = bearing_friction}};
}

}  // namespace firn::verification
