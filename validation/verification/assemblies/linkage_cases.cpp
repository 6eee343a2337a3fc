// Mechanisms of several bodies: open chains, closed loops, gears.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "validation/verification/fixtures/closed_forms.h"
#include "validation/verification/fixtures/mechanisms.h"

namespace firn::verification {

std::vector<VerificationCase> linkage_cases();

namespace {

using namespace scenes;

constexpr int kReferenceSteps = 5000;  // so many that their error does not count

double uniform_between(std::mt19937& random, double low, double high) {
  return std::uniform_real_distribution(low, high)(random);
}

double coordinate_of(const Solver& solver, int frame) {
  return solver.frames()[static_cast<std::size_t>(frame)].joints[0].coordinate;
}

// Lagrange's equations of bars of m1, l1 and m2, l2, for a and the angle b of the second against
// the first.
double double_pendulum_error(std::mt19937& random) {
  const double l1 = uniform_between(random, 0.1, 0.3), l2 = uniform_between(random, 0.1, 0.3),
               m1 = uniform_between(random, 0.1, 0.5), m2 = uniform_between(random, 0.1, 0.5);
  const auto rates = [&](const std::vector<double>& y) {
    const double a = y[0], c = y[0] + y[1], da = y[2], dc = y[2] + y[3];
    const double i1 = m1 * l1 * l1 / 3 + m2 * l1 * l1, i2 = m2 * l2 * l2 / 3, k = m2 * l1 * l2 / 2;
    const double m = k * std::cos(c - a), s = k * std::sin(c - a), det = i1 * i2 - m * m;
    const double f1 = s * dc * dc - (m1 / 2 + m2) * kGravity * l1 * std::cos(a),
                 f2 = -s * da * da - m2 * kGravity * l2 / 2 * std::cos(c);
    const double dda = (f1 * i2 - m * f2) / det, ddc = (i1 * f2 - m * f1) / det;
    return std::vector<double>{y[2], y[3], dda, ddc - dda};
  };
  const std::vector<double> exact = runge_kutta({0, 0, 0, 0}, 0.3, kReferenceSteps, rates);
  Model model = mechanism();
  const int upper = add_bar(model, m1, Vec3::Zero(), Vec3(l1, 0, 0), -1);
  const int lower = add_bar(model, m2, Vec3(l1, 0, 0), Vec3(l1 + l2, 0, 0), upper);
  model.timestep = 1e-4;
  Solver solver(model);
  run(solver, 0.3);
  return std::hypot(coordinate_of(solver, upper) - exact[0],
                    coordinate_of(solver, lower) - exact[1]);
}

// The same of a bar on a cart.
double cart_error(std::mt19937& random) {
  const double cart = uniform_between(random, 0.1, 1), bob = uniform_between(random, 0.1, 0.5),
               length = uniform_between(random, 0.1, 0.3), i = bob * length * length / 3,
               k = bob * length / 2;
  const auto rates = [&](const std::vector<double>& y) {
    const double c = std::cos(y[1]), m = -k * std::sin(y[1]), det = (cart + bob) * i - m * m;
    const double f1 = k * c * y[3] * y[3], f2 = -k * kGravity * c;
    return std::vector<double>{y[2], y[3], (f1 * i - m * f2) / det,
                               ((cart + bob) * f2 - m * f1) / det};
  };
  const std::vector<double> exact = runge_kutta({0, 0, 0, 0}, 0.3, kReferenceSteps, rates);
  Model model = mechanism();
  const int base =
      add_mover(model, "cart", cart, Vec3::Zero(), Vec3::Ones(), {slider(Vec3::UnitX())});
  const int bar = add_bar(model, bob, Vec3::Zero(), Vec3(length, 0, 0), base);
  model.timestep = 1e-4;
  Solver solver(model);
  run(solver, 0.3);
  return std::hypot((coordinate_of(solver, base) - exact[0]) / length,
                    coordinate_of(solver, bar) - exact[1]);
}

// m, of the piston of a driven slider-crank from its closed form, at most over a turn.
double slider_crank_error(std::mt19937& random) {
  const double r = uniform_between(random, 0.02, 0.05), l = uniform_between(random, 0.12, 0.2),
               height = uniform_between(random, -0.04, 0.04),
               reach = r + std::sqrt(l * l - height * height);
  const Vec3 end(r, 0, 0), wrist(reach, 0, height);
  Model model = mechanism();
  const int crank = add_bar(model, 0.1, Vec3::Zero(), end, -1),
            rod = add_bar(model, 0.2, end, wrist, crank),
            piston = add_mover(model, "piston", 0.3, wrist, Vec3::Ones(), {slider(Vec3::UnitX())},
                               wrist);
  model.couplings = {pin(rod, piston, wrist)};
  drive_at(model, crank, 2 * std::numbers::pi);
  model.timestep = 5e-4;
  Solver solver(model);
  double worst = 0;
  for (int k = 0; k < 2000; ++k) {
    solver.step();
    const double a = coordinate_of(solver, crank), up = height - r * std::sin(a);
    const double x = r * std::cos(a) + std::sqrt(l * l - up * up);
    worst = std::max(worst, std::abs(coordinate_of(solver, piston) - (x - reach)));
  }
  return worst;
}

// m, of the pin between coupler and rocker from where two circles meet, at most over a turn of the
// crank, which is the shortest link (Grashof).
double four_bar_error(std::mt19937& random) {
  const double r = uniform_between(random, 0.03, 0.05), base = uniform_between(random, 0.18, 0.22),
               l = uniform_between(random, 0.17, 0.2), c = uniform_between(random, 0.17, 0.2);
  const Vec3 pivot(base, 0, 0);
  const auto meeting = [&](double angle) {
    const Vec3 from(r * std::cos(angle), 0, r * std::sin(angle)), apart = pivot - from;
    const double d = apart.norm(), along = (l * l - c * c + d * d) / (2 * d),
                 across = std::sqrt(l * l - along * along);
    const Vec3 unit = apart / d;
    return Vec3(from + along * unit + across * Vec3(-unit.z(), 0, unit.x()));
  };
  const Vec3 end(r, 0, 0), joint = meeting(0);
  Model model = mechanism();
  const int crank = add_bar(model, 0.1, Vec3::Zero(), end, -1),
            coupler = add_bar(model, 0.2, end, joint, crank),
            rocker = add_bar(model, 0.2, pivot, joint, -1);
  model.couplings = {pin(coupler, rocker, joint)};
  drive_at(model, crank, 2 * std::numbers::pi);
  model.timestep = 5e-4;
  Solver solver(model);
  double worst = 0;
  for (int k = 0; k < 2000; ++k) {
    solver.step();
    const FrameState at = solver.frames()[static_cast<std::size_t>(rocker)];
    const Vec3 pin_of_rocker = at.position + at.orientation * (joint - pivot);
    worst = std::max(worst, (pin_of_rocker - meeting(coordinate_of(solver, crank))).norm());
  }
  return worst;
}

// Relative error of the speed that a constant torque gives two geared rotors.
double gear_error(std::mt19937& random) {
  const double own = uniform_between(random, 1e-3, 5e-3),
               other = uniform_between(random, 1e-3, 5e-3), ratio = uniform_between(random, -4, 4);
  Model model = mechanism();
  const int a = add_mover(model, "a", 1, Vec3::Zero(), Vec3(1, own, 1), {hinge(Vec3::UnitY())});
  const int b = add_mover(model, "b", 1, Vec3(0.1, 0, 0), Vec3(1, other, 1), {hinge(Vec3::UnitY())},
                          Vec3(0.1, 0, 0));
  Coupling gear = pin(a, b, Vec3::Zero());
  gear.kind = Coupling::Kind::gear;
  gear.ratio = ratio;
  model.couplings = {gear};
  drive_at(model, a, 1e6, 0.01);
  model.timestep = 1e-4;
  Solver solver(model);
  run(solver, 0.1);
  const double expected = 0.01 * 0.1 / (own + ratio * ratio * other);
  return std::abs(solver.frames()[static_cast<std::size_t>(a)].joints[0].rate / expected - 1);
}

std::vector<Check> linkages() {
  constexpr int kMembers = 10;
  std::vector<Check> checks;
  const auto worst_of = [&](const char* what, double most, const char* unit,
                            double (*error)(std::mt19937&)) {
    std::mt19937 random(1);
    double worst = 0;
    for (int k = 0; k < kMembers; ++k) worst = std::max(worst, error(random));
    checks.push_back({fmt::format("{}, largest error of {} drawn ones", what, kMembers), worst,
                      most, 0, Bound::at_most, unit});
  };
  worst_of("double pendulum after 0.3 s", 1e-4, "rad", double_pendulum_error);
  worst_of("pendulum on a cart after 0.3 s", 1e-4, "rad", cart_error);
  worst_of("piston of a slider-crank over a turn", 1e-11, "m", slider_crank_error);
  worst_of("rocker of a four-bar linkage over a turn", 1e-11, "m", four_bar_error);
  worst_of("speed of two geared rotors", 1e-9, "1", gear_error);
  return checks;
}

}  // namespace

std::vector<VerificationCase> linkage_cases() {
  return {{.name = "machine.linkages",
           .title = "Bodies on each other's joints, closed loops and gears",
           .reference = "Lagrange's equations by fourth-order Runge-Kutta; closed forms of the "
                        "slider-crank and of circles that meet; M t / (J1 + i^2 J2)",
           .remark = "Lengths, masses and ratios are drawn. Loops hold to rounding; pendulums are "
                     "of second order in the step of 0.1 ms.",
           .run = linkages}};
}

}  // namespace firn::verification
