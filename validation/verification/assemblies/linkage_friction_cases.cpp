// Friction in the pins of linkages, and the energy balance of machine parts.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "validation/verification/fixtures/closed_forms.h"
#include "validation/verification/fixtures/mechanisms.h"

namespace firn::verification {

std::vector<VerificationCase> linkage_friction_cases();

namespace {

using namespace scenes;

double drawn(std::mt19937& random, double low, double high) {
  return std::uniform_real_distribution(low, high)(random);
}

// A pin along y of this radius, m.
void add_pin_friction(Coupling& coupling, double friction, double radius) {
  coupling.direction = Vec3::UnitY();
  coupling.friction_coefficient = friction;
  coupling.bearing_radius = radius;
}

// A pendulum that a coupling holds at a pin of the world, released at rest.
struct PinnedPendulum {
  double mass = 0.3, arm = 0.2, own_inertia = 1e-3;     // kg, m, kg m^2
  double friction = 0.2, radius = 5e-3, start = 0.048;  // 1, m, rad from straight down

  double weight() const { return mass * kGravity; }
  double inertia() const { return own_inertia + mass * arm * arm; }
  // rad, amplitude that each half swing loses while it is small: twice the angle at which the
  // friction mu r m g of the pin holds the weight.
  double loss() const { return 2 * friction * radius / arm; }
  // J, as it falls.
  double released(double from, double to) const {
    return weight() * arm * (std::cos(to) - std::cos(from));
  }
};

// J w' = -m g a sin(angle) -+ mu r N, where the pin bears N = m |(a w^2 + g cos, a w' + g sin)|.
double pendulum_acceleration(const PinnedPendulum& p, double angle, double rate, double sign) {
  constexpr int kRepetitions = 8;  // each reduces the error by a factor of mu r m a / J
  double pin = p.weight(), acceleration = 0;
  for (int k = 0; k < kRepetitions; ++k) {
    acceleration =
        -(p.weight() * p.arm * std::sin(angle) + sign * p.friction * p.radius * pin) / p.inertia();
    pin = p.mass * std::hypot(p.arm * rate * rate + kGravity * std::cos(angle),
                              p.arm * acceleration + kGravity * std::sin(angle));
  }
  return acceleration;
}

// rad, where it turns, by the fourth-order Runge-Kutta method.
std::vector<double> exact_turns(const PinnedPendulum& p, std::size_t count) {
  constexpr double kStep = 1e-4;  // s
  std::vector<double> turns;
  std::vector<double> y = {p.start, 0};
  while (turns.size() < count) {
    const double sign = y[0] > 0 ? -1 : 1;  // of the rate
    double before = 0;
    while (sign * y[1] >= 0) {
      before = y[1];
      y = runge_kutta(y, kStep, 1, [&](const std::vector<double>& at) {
        return std::vector<double>{at[1], pendulum_acceleration(p, at[0], at[1], sign)};
      });
    }
    // Back by the time since the rate was zero.
    const double since = kStep * y[1] / (y[1] - before);
    y = {y[0] - 0.5 * since * y[1], 0};
    turns.push_back(y[0]);
  }
  return turns;
}

Solver pinned_pendulum(const PinnedPendulum& p) {
  Model model = mechanism();
  const int link =
      add_mover(model, "link", p.mass, p.arm * Vec3(std::sin(p.start), 0, -std::cos(p.start)),
                Vec3::Constant(p.own_inertia),
                {slider(Vec3::UnitX()), slider(Vec3::UnitZ()), hinge(-Vec3::UnitY())});
  model.couplings = {pin(-1, link, Vec3::Zero())};
  add_pin_friction(model.couplings[0], p.friction, p.radius);
  model.timestep = 1e-4;
  return Solver(model);
}

FrameState::JointState pendulum_turn(const Solver& solver) {
  return solver.frames()[0].joints.back();
}

std::vector<double> simulated_turns(const PinnedPendulum& p, std::size_t count, Solver& solver) {
  constexpr double kLongest = 20, kAtRest = 1e-9;  // s, rad/s
  std::vector<double> turns;
  double before = 0;
  while (turns.size() < count && solver.time() < kLongest) {
    solver.step();
    const FrameState::JointState now = pendulum_turn(solver);
    const double sign = before < 0 ? -1 : 1;
    if (sign * before > kAtRest && sign * now.rate <= kAtRest)
      turns.push_back(p.start + now.coordinate);
    before = now.rate;
  }
  turns.resize(count, std::nan(""));
  return turns;
}

void add_small_swings(std::vector<Check>& checks) {
  const PinnedPendulum p;
  Solver solver = pinned_pendulum(p);
  const std::vector<double> turns = simulated_turns(p, 5, solver);
  for (std::size_t k = 0; k < turns.size(); ++k) {
    // The last amplitude is less than the loss: it stops on the same side.
    const double amplitude = p.start - static_cast<double>(k + 1) * p.loss();
    checks.push_back({fmt::format("amplitude after {} half swings, less 2 mu r / a each", k + 1),
                      k % 2 == 0 ? -turns[k] : turns[k], amplitude, 5e-5, Bound::absolute, "rad"});
  }
  run(solver, 0.5);
  const FrameState::JointState rest = pendulum_turn(solver);
  checks.push_back({"angle half a second later", p.start + rest.coordinate, turns.back(), 1e-9,
                    Bound::absolute, "rad"});
  checks.push_back({"speed at rest", std::abs(rest.rate), 1e-10, 0, Bound::at_most, "rad/s"});
  checks.push_back({"heat of the pin, the height that was lost",
                    solver.couplings()[0].dissipated_friction,
                    p.released(p.start, p.start + rest.coordinate), 1e-4, Bound::relative, "J"});
}

void add_large_swings(std::vector<Check>& checks) {
  constexpr int kMembers = 5;
  std::mt19937 random(1);
  double worst = 0;
  for (int member = 0; member < kMembers; ++member) {
    const PinnedPendulum p{drawn(random, 0.1, 0.5),   drawn(random, 0.1, 0.3),
                           drawn(random, 1e-4, 2e-3), drawn(random, 0.1, 0.4),
                           drawn(random, 3e-3, 8e-3), drawn(random, 0.4, 1.2)};
    Solver solver = pinned_pendulum(p);
    const std::vector<double> turns = simulated_turns(p, 3, solver), exact = exact_turns(p, 3);
    for (std::size_t k = 0; k < exact.size(); ++k)
      worst = std::max(worst, std::abs(turns[k] - exact[k]) / p.loss());
  }
  checks.push_back({fmt::format("swings of 0.4 to 1.2 rad, largest error of a turn of {} drawn "
                                "ones, over 2 mu r / a",
                                kMembers),
                    worst, 2e-4, 0, Bound::at_most, "1"});
}

// A slider-crank that is turned slowly under the weight of its parts, which acts along the slide
// towards the crank.
struct LoadedCrank {
  double crank, rod, height, angle, sign;  // m, m, m, rad, of the turn
  double crank_mass, rod_mass, piston_mass;
  double friction[3], radius[3];  // of the pins at the ground, crank and piston; 1, m

  Vec3 crank_end() const { return crank * Vec3(std::cos(angle), 0, std::sin(angle)); }
  Vec3 wrist() const {
    const double rise = height - crank_end().z();
    return {crank_end().x() + std::sqrt(rod * rod - rise * rise), 0, height};
  }
};

LoadedCrank drawn_crank(std::mt19937& random) {
  LoadedCrank c{};
  c.crank = drawn(random, 0.02, 0.05);
  c.rod = drawn(random, 0.12, 0.2);
  c.height = drawn(random, -0.03, 0.03);
  // Not near a dead center, nor where the rod turns back.
  c.angle = drawn(random, 0.3, 1.2) + std::numbers::pi * std::floor(drawn(random, 0, 2));
  c.sign = drawn(random, -1, 1) < 0 ? -1 : 1;
  c.crank_mass = drawn(random, 0.05, 0.2);
  c.rod_mass = drawn(random, 0.05, 0.2);
  c.piston_mass = drawn(random, 1, 3);
  for (int k = 0; k < 3; ++k) {
    c.friction[k] = drawn(random, 0.1, 0.4);
    c.radius[k] = drawn(random, 2e-3, 5e-3);
  }
  return c;
}

struct CrankLoads {
  double torque = 0, wrist = 0;  // N m of the motor, N of the pin at the piston
};

double moment(const Vec3& arm, const Vec3& force) { return -arm.cross(force).y(); }  // from x to z

// Balances of forces and moments of all parts. Each pin gives a moment of mu r times its load
// against its turn, so that its force is tangent to a circle of this radius: the friction circle.
CrankLoads crank_statics(const LoadedCrank& c) {
  const Vec3 end = c.crank_end(), rod = c.wrist() - end;
  const auto weight = [](double mass) { return Vec3(-mass * kGravity, 0, 0); };
  const auto against = [](double rate) { return rate > 0 ? -1.0 : 1.0; };
  const double rod_rate = -c.sign * end.x() / rod.x();  // over that of the crank
  const auto pin = [&](int k, const Vec3& load, double rate) {
    return against(rate) * c.friction[k] * c.radius[k] * load.norm();
  };
  // Of the piston on the rod. The slide bears the piston's force along z.
  Vec3 at_wrist = weight(c.piston_mass), at_crank = Vec3::Zero();
  double crank_pin = 0;
  for (int repetition = 0; repetition < 100; ++repetition) {
    at_crank = -at_wrist - weight(c.rod_mass);  // of the crank on the rod
    crank_pin = pin(1, at_crank, rod_rate - c.sign);
    const double others =
        crank_pin + pin(2, at_wrist, rod_rate) + moment(0.5 * rod, weight(c.rod_mass));
    at_wrist.z() = (rod.z() * at_wrist.x() - others) / rod.x();
  }
  const Vec3 at_ground = at_crank - weight(c.crank_mass);  // of the ground on the crank
  CrankLoads loads;
  loads.torque = moment(end, at_crank) - moment(0.5 * end, weight(c.crank_mass)) + crank_pin -
                 pin(0, at_ground, c.sign);
  loads.wrist = at_wrist.norm();
  return loads;
}

CrankLoads simulated_crank(const LoadedCrank& c) {
  constexpr double kSpeed = 1e-3, kStep = 1e-4;  // rad/s, without inertia; s
  constexpr int kBefore = 50, kMean = 10;        // steps
  Model model = mechanism();
  model.gravity = Vec3(-kGravity, 0, 0);
  const Vec3 end = c.crank_end(), wrist = c.wrist();
  const int crank = add_bar(model, c.crank_mass, Vec3::Zero(), end, -1),
            rod = add_bar(model, c.rod_mass, end, wrist, crank),
            piston = add_mover(model, "piston", c.piston_mass, wrist, Vec3::Ones(),
                               {slider(Vec3::UnitX())}, wrist);
  for (int k = 0; k < 2; ++k) {
    Joint& joint = model.frames[index(k == 0 ? crank : rod)].free->joints[0];
    joint.friction_coefficient = c.friction[k];
    joint.bearing_radius = c.radius[k];
  }
  model.couplings = {pin(rod, piston, wrist)};
  add_pin_friction(model.couplings[0], c.friction[2], c.radius[2]);
  drive_at(model, crank, c.sign * kSpeed);
  model.timestep = kStep;
  Solver solver(model);
  for (int k = 0; k < kBefore; ++k) solver.step();
  solver.clear_boundary_loads();
  for (int k = 0; k < kMean; ++k) solver.step();
  const double time = kMean * kStep;
  return {solver.frames()[index(crank)].joints[0].motor_impulse / time,
          solver.couplings()[0].impulse.norm() / time};
}

void add_cranks(std::vector<Check>& checks) {
  constexpr int kMembers = 10;
  std::mt19937 random(1);
  double torque = 0, force = 0;
  for (int member = 0; member < kMembers; ++member) {
    const LoadedCrank c = drawn_crank(random);
    const CrankLoads loads = simulated_crank(c), exact = crank_statics(c);
    const double weight = c.piston_mass * kGravity;
    torque = std::max(torque, std::abs(loads.torque - exact.torque) / (weight * c.crank));
    force = std::max(force, std::abs(loads.wrist - exact.wrist) / weight);
  }
  const std::string drawn_ones = fmt::format("largest error of {} drawn ones, over ", kMembers);
  checks.push_back({"torque that turns a slider-crank slowly, " + drawn_ones + "m g r", torque,
                    1e-4, 0, Bound::at_most, "1"});
  checks.push_back({"force of its pin at the piston, " + drawn_ones + "m g", force, 1e-4, 0,
                    Bound::at_most, "1"});
}

std::vector<Check> pin_friction() {
  std::vector<Check> checks;
  add_small_swings(checks);
  add_large_swings(checks);
  add_cranks(checks);
  return checks;
}

// J, the largest change of the balance over a duration (s).
double part_imbalance(Solver& solver, double duration) {
  const double start = solver.energy().free_bodies.balance(), end = solver.time() + duration;
  double largest = 0;
  while (solver.time() < end) {
    for (int k = 0; k < 5; ++k) solver.step();
    largest = std::max(largest, std::abs(solver.energy().free_bodies.balance() - start));
  }
  return largest;
}

// A crank with springs, dampers and friction that a motor speeds up.
Solver driven_crank() {
  Model model = mechanism();
  const Vec3 end(0.04, 0, 0), wrist(0.19, 0, 0.01);
  const int crank = add_bar(model, 0.1, Vec3::Zero(), end, -1),
            rod = add_bar(model, 0.2, end, wrist, crank),
            piston = add_mover(model, "piston", 0.3, wrist, Vec3::Constant(1e-4),
                               {slider(Vec3::UnitX())}, wrist);
  for (const int f : {crank, rod}) {
    Joint& joint = model.frames[index(f)].free->joints[0];
    joint.friction_coefficient = 0.2;
    joint.bearing_radius = 4e-3;
    joint.damping = 5e-4;
  }
  Joint& guide = model.frames[index(piston)].free->joints[0];
  guide.friction_coefficient = 0.1;
  guide.stiffness = 40;
  model.couplings = {pin(rod, piston, wrist)};
  add_pin_friction(model.couplings[0], 0.3, 4e-3);
  drive_at(model, crank, 25, 0.4);
  model.frames[index(crank)].free->joints[0].motors[0].no_load_speed = 25;
  model.timestep = 1e-4;
  return Solver(model);
}

// A belt takes a box along and lets it slip first.
Solver box_on_belt() {
  constexpr double kMass = 2, kStiffness = 1e6, kDent = kMass * kGravity / kStiffness;
  Model model = mechanism();
  const int box = add_mover(model, "box", kMass, {0, 0, 0.05}, Vec3::Constant(0.01),
                            {slider(Vec3::UnitX()), slider(Vec3::UnitZ())});
  const int belt = add_panel(model, "belt", {-1, -0.2, -0.1}, {1, 0.2, 0}),
            load = add_panel(model, "load", {-0.05, -0.05, -kDent}, {0.05, 0.05, 0.1 - kDent});
  Motion along;
  along.velocity = {0.5, 0, 0};
  model.boundaries[index(belt)].motions = {along};
  model.boundaries[index(load)].frame = box;
  add_contact(model, load, belt, 0.3, 0.5, kStiffness);
  model.timestep = 2e-5;
  return Solver(model);
}

std::vector<Check> part_energy() {
  std::vector<Check> checks;
  const auto add = [&](const char* what, Solver solver, double duration, double most) {
    const double error = part_imbalance(solver, duration);
    const FreeBodyEnergy e = solver.energy().free_bodies;
    const double turned =
        std::max(e.work, e.dissipated_friction + e.dissipated_damping + e.dissipated_contacts);
    checks.push_back({fmt::format("{}: largest imbalance over the energy turned over", what),
                      error / turned, most, 0, Bound::at_most, "1"});
  };
  add("pendulum on a pin with friction", pinned_pendulum({.start = 0.8}), 2, 1e-5);
  add("slider-crank with friction, dampers, a spring and a motor", driven_crank(), 1, 1e-3);
  add("box that a belt takes along", box_on_belt(), 0.4, 2e-3);
  Solver belt = box_on_belt();
  run(belt, 0.4);
  const FreeBodyEnergy e = belt.energy().free_bodies;
  checks.push_back({"work of the belt, m v^2", e.work, 0.5, 0.02, Bound::relative, "J"});
  checks.push_back({"heat in its contact, half of that", e.dissipated_contacts, 0.25, 0.02,
                    Bound::relative, "J"});
  return checks;
}

}  // namespace

std::vector<VerificationCase> linkage_friction_cases() {
  return {
      {.name = "machine.pin_friction",
       .title = "Friction in the pins of couplings",
       .reference =
           "amplitude less 2 mu r / a in each half swing; J w' = -m g a sin q -+ mu r N by "
           "fourth-order Runge-Kutta; statics of a slider-crank with friction circles of mu r",
       .remark = "Swings of less than 0.05 rad agree with the linear decay within 0.3 % of a loss. "
                 "The load of a pin is that of the step before. Where it rises and falls between "
                 "two turns, the errors of first order cancel.",
       .run = pin_friction},
      {.name = "machine.energy",
       .title = "Energy balance of machine parts",
       .reference =
           "kinetic, gravitational, elastic and dissipated energy less the work of motors, "
           "particles and prescribed motions is constant",
       .remark = "Second order in the time step.",
       .run = part_energy}};
}

}  // namespace firn::verification
