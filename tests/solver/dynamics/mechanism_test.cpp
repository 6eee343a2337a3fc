// Mechanisms: bodies on joints of each other, closed loops, gears and cams, against closed forms
// and against other integrations of the equations of motion.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "tests/support/error_of.h"
#include "validation/verification/fixtures/mechanisms.h"

namespace firn {
namespace {

using scenes::add_bar;
using scenes::add_mover;
using scenes::drive_at;
using scenes::hinge;
using scenes::kGravity;
using scenes::mechanism;
using scenes::pin;
using scenes::runge_kutta;
using scenes::slider;
using std::numbers::pi;

double coordinate(const Solver& solver, int frame, std::size_t joint = 0) {
  return solver.frames().at(static_cast<std::size_t>(frame)).joints.at(joint).coordinate;
}
double rate(const Solver& solver, int frame, std::size_t joint = 0) {
  return solver.frames().at(static_cast<std::size_t>(frame)).joints.at(joint).rate;
}

Solver run_for(Model model, double timestep, double duration,
               const std::function<void(Solver&)>& start = {}) {
  model.timestep = timestep;
  Solver solver(std::move(model));
  if (start) start(solver);
  for (long k = 0; k < std::lround(duration / timestep); ++k) solver.step();
  return solver;
}

// Two bars, drawn horizontal, one on the end of the other.
constexpr double kL1 = 0.2, kL2 = 0.15, kM1 = 0.3, kM2 = 0.2;
Model double_pendulum() {
  Model model = mechanism();
  const int upper = add_bar(model, kM1, Vec3::Zero(), Vec3(kL1, 0, 0), -1);
  add_bar(model, kM2, Vec3(kL1, 0, 0), Vec3(kL1 + kL2, 0, 0), upper);
  return model;
}

// Lagrange's equations for the angles a and a + b from the horizontal.
std::vector<double> double_pendulum_rates(const std::vector<double>& y) {
  const double a = y[0], c = y[0] + y[1], da = y[2], dc = y[2] + y[3];
  const double i1 = kM1 * kL1 * kL1 / 3 + kM2 * kL1 * kL1, i2 = kM2 * kL2 * kL2 / 3,
               k = kM2 * kL1 * kL2 / 2;
  const double m = k * std::cos(c - a), s = k * std::sin(c - a);
  const double f1 = s * dc * dc - (kM1 / 2 + kM2) * kGravity * kL1 * std::cos(a);
  const double f2 = -s * da * da - kM2 * kGravity * kL2 / 2 * std::cos(c);
  const double det = i1 * i2 - m * m;
  const double dda = (f1 * i2 - m * f2) / det, ddc = (i1 * f2 - m * f1) / det;
  return {y[2], y[3], dda, ddc - dda};
}

double energy_of_double_pendulum(const Solver& solver) {
  const double a = coordinate(solver, 0), c = a + coordinate(solver, 1), da = rate(solver, 0),
               dc = da + rate(solver, 1);
  const double kinetic = (kM1 / 6 + kM2 / 2) * kL1 * kL1 * da * da + kM2 / 6 * kL2 * kL2 * dc * dc +
                         kM2 / 2 * kL1 * kL2 * std::cos(c - a) * da * dc;
  const double height1 = kL1 * std::sin(a), height2 = kL2 * std::sin(c);
  return kinetic + kGravity * (kM1 * height1 / 2 + kM2 * (height1 + height2 / 2));
}

TEST(Mechanism, DoublePendulumSwingsAsLagrangesEquationsOfSecondOrderInTheStep) {
  const std::vector<double> exact = runge_kutta({0, 0, 0, 0}, 0.5, 20000, double_pendulum_rates);
  std::vector<double> errors;
  for (const double dt : {2e-3, 1e-3, 5e-4}) {
    const Solver solver = run_for(double_pendulum(), dt, 0.5);
    errors.push_back(
        std::hypot(coordinate(solver, 0) - exact[0], coordinate(solver, 1) - exact[1]));
  }
  EXPECT_LT(errors[2], 1e-3);
  EXPECT_NEAR(errors[0] / errors[1], 4, 0.6);
  EXPECT_NEAR(errors[1] / errors[2], 4, 0.3);
}

TEST(Mechanism, KeepsItsEnergyOverManySwings) {
  Model model = double_pendulum();
  model.timestep = 1e-4;
  Solver solver(std::move(model));
  const double scale = kGravity * (kM1 + kM2) * kL1;
  double worst = 0;
  for (int k = 0; k < 50000; ++k) {
    solver.step();
    worst = std::max(worst, std::abs(energy_of_double_pendulum(solver)) / scale);
  }
  EXPECT_LT(worst, 2e-5);
}

TEST(Mechanism, PendulumOnACartMovesAsLagrangesEquations) {
  const double cart = 0.5, bob = 0.2, arm = 0.1, own = bob * 4 * arm * arm / 12;
  Model model = mechanism();
  const int base =
      add_mover(model, "cart", cart, Vec3::Zero(), Vec3::Ones(), {slider(Vec3::UnitX())});
  add_bar(model, bob, Vec3::Zero(), Vec3(2 * arm, 0, 0), base);
  const auto rates = [&](const std::vector<double>& y) {
    const double c = std::cos(y[1]), s = std::sin(y[1]);
    const double i = own + bob * arm * arm, k = bob * arm;
    const double f1 = k * c * y[3] * y[3], f2 = -k * kGravity * c, m = -k * s;
    const double det = (cart + bob) * i - m * m;
    return std::vector<double>{y[2], y[3], (f1 * i - m * f2) / det,
                               ((cart + bob) * f2 - m * f1) / det};
  };
  const std::vector<double> exact = runge_kutta({0, 0, 0, 0}, 0.4, 20000, rates);
  const Solver solver = run_for(model, 1e-4, 0.4);
  EXPECT_NEAR(coordinate(solver, 0), exact[0], 1e-6);
  EXPECT_NEAR(coordinate(solver, 1), exact[1], 2e-5);
}

// A crank about the origin, a rod on its end, and a piston along x that holds the rod's end.
struct SliderCrank {
  Model model = mechanism();
  int crank, rod, piston;
  SliderCrank(double r, double l, double height) {
    const Vec3 end(r, 0, 0), wrist(r + std::sqrt(l * l - height * height), 0, height);
    crank = add_bar(model, 0.1, Vec3::Zero(), end, -1);
    rod = add_bar(model, 0.2, end, wrist, crank);
    piston = add_mover(model, "piston", 0.3, wrist, Vec3::Ones(), {slider(Vec3::UnitX())}, wrist);
    model.couplings = {pin(rod, piston, wrist)};
  }
};

TEST(Mechanism, SliderCrankFollowsItsClosedFormOverWholeTurns) {
  std::mt19937 random(7);
  for (int k = 0; k < 5; ++k) {
    const double r = std::uniform_real_distribution(0.02, 0.05)(random),
                 l = std::uniform_real_distribution(0.12, 0.2)(random),
                 height = std::uniform_real_distribution(-0.04, 0.04)(random),
                 speed = std::uniform_real_distribution(-30.0, 30.0)(random);
    SliderCrank machine(r, l, height);
    drive_at(machine.model, machine.crank, speed);
    machine.model.timestep = 1e-4;
    const double drawn = r + std::sqrt(l * l - height * height);
    Solver solver(machine.model);
    double worst = 0;
    for (int step = 0; step < 5000; ++step) {
      solver.step();
      const double a = coordinate(solver, machine.crank), up = height - r * std::sin(a);
      const double x = r * std::cos(a) + std::sqrt(l * l - up * up);
      worst = std::max(worst, std::abs(coordinate(solver, machine.piston) - (x - drawn)));
    }
    EXPECT_LT(worst, 1e-12);
    EXPECT_NEAR(rate(solver, machine.crank), speed, 1e-9 * std::abs(speed));
    EXPECT_NEAR(coordinate(solver, machine.crank), speed * 0.5, 1e-9);
  }
}

TEST(Mechanism, TheMotorOfASliderCrankGivesTheWorkThatItsPartsReceive) {
  SliderCrank machine(0.04, 0.15, 0.01);
  drive_at(machine.model, machine.crank, 20);
  machine.model.timestep = 5e-5;
  Solver solver(machine.model);
  const auto energy = [&] {
    double sum = 0;
    const std::vector<FrameState> frames = solver.frames();
    for (std::size_t f = 0; f < frames.size(); ++f) {
      const FreeBody& body = *machine.model.frames[f].free;
      const Vec3 arm = frames[f].orientation * (body.center - machine.model.frames[f].origin);
      Vec3 angular_velocity = Vec3::Zero();
      double turn = 0;  // about -y
      if (f == 0) turn = rate(solver, machine.crank);
      if (f == 1) turn = rate(solver, machine.crank) + rate(solver, machine.rod);
      angular_velocity = -turn * Vec3::UnitY();
      Vec3 velocity = Vec3::Zero();
      const Vec3 crank_angular_velocity = -rate(solver, machine.crank) * Vec3::UnitY();
      if (f == 0) velocity = angular_velocity.cross(arm);
      if (f == 1)
        velocity = crank_angular_velocity.cross(frames[1].position) + angular_velocity.cross(arm);
      if (f == 2) velocity = Vec3(rate(solver, machine.piston), 0, 0);
      sum += 0.5 * body.mass * velocity.squaredNorm() +
             0.5 * angular_velocity.dot(body.inertia * angular_velocity) +
             body.mass * kGravity * (frames[f].position + arm).z();
    }
    return sum;
  };
  solver.step();
  double before = energy(), worst = 0, work = 0, largest = 0;
  for (int k = 0; k < 6000; ++k) {
    solver.clear_boundary_loads();
    solver.step();
    work += 20 * solver.frames()[0].joints[0].motor_impulse;
    largest = std::max(largest, std::abs(energy() - before));
    worst = std::max(worst, std::abs(energy() - before - work));
  }
  EXPECT_GT(largest, 0.05);
  EXPECT_LT(worst, 1e-4 * largest);
}

TEST(Mechanism, FourBarLinkageFollowsTheCircleOfItsRocker) {
  const Vec3 pivot(0.2, 0, 0), end(0, 0, 0.05), joint = Vec3(0.18, 0, 0.15);
  Model model = mechanism();
  const int crank = add_bar(model, 0.1, Vec3::Zero(), end, -1);
  const int coupler = add_bar(model, 0.2, end, joint, crank);
  const int rocker = add_bar(model, 0.2, pivot, joint, -1);
  model.couplings = {pin(coupler, rocker, joint)};
  drive_at(model, crank, 12);
  model.timestep = 1e-4;
  const double l = (joint - end).norm(), c = (joint - pivot).norm();
  Solver solver(model);
  double worst = 0;
  for (int k = 0; k < 10000; ++k) {
    solver.step();
    // The joint lies where the circles about crank end and pivot meet, above the line between.
    const double a = pi / 2 + coordinate(solver, crank);
    const Vec3 from(0.05 * std::cos(a), 0, 0.05 * std::sin(a)), apart = pivot - from;
    const double d = apart.norm(), along = (l * l - c * c + d * d) / (2 * d),
                 across = std::sqrt(l * l - along * along);
    const Vec3 unit = apart / d, up(-unit.z(), 0, unit.x());
    const Vec3 at = from + along * unit + across * up;
    const FrameState state = solver.frames()[static_cast<std::size_t>(rocker)];
    worst = std::max(worst, (state.position + state.orientation * (joint - pivot) - at).norm());
  }
  EXPECT_LT(worst, 1e-11);
}

TEST(Mechanism, LoopOfHingesWithDependentRowsHoldsAndBearsItsLoad) {
  // A beam of two hinges to the world cannot move: each bears half of its weight.
  for (const Coupling::Kind kind : {Coupling::Kind::ball, Coupling::Kind::hinge}) {
    Model model = mechanism();
    const int beam = add_bar(model, 2, Vec3::Zero(), Vec3(0.4, 0, 0), -1);
    model.couplings = {pin(-1, beam, Vec3(0.4, 0, 0))};
    model.couplings[0].kind = kind;
    model.couplings[0].direction = Vec3::UnitY();
    model.timestep = 1e-4;
    Solver solver(model);
    for (int k = 0; k < 10; ++k) solver.step();
    solver.clear_boundary_loads();
    for (int k = 0; k < 100; ++k) solver.step();
    EXPECT_NEAR(coordinate(solver, beam), 0, 1e-15);
    EXPECT_NEAR(solver.couplings()[0].impulse.z() / 0.01, kGravity, 1e-9);
    EXPECT_NEAR(solver.frames()[0].reaction_impulse.z() / 0.01, kGravity, 1e-9);
  }
}

TEST(Mechanism, JointsBearWhatHangsOnThem) {
  Model model = mechanism();  // hanging straight down
  const int upper = add_bar(model, 1, Vec3::Zero(), Vec3(0, 0, -0.2), -1);
  add_bar(model, 0.5, Vec3(0, 0, -0.2), Vec3(0, 0, -0.3), upper);
  model.timestep = 1e-4;
  Solver solver(model);
  for (int k = 0; k < 10; ++k) solver.step();
  solver.clear_boundary_loads();
  for (int k = 0; k < 100; ++k) solver.step();
  EXPECT_NEAR(solver.frames()[0].reaction_impulse.z() / 0.01, 1.5 * kGravity, 1e-9);
  EXPECT_NEAR(solver.frames()[1].reaction_impulse.z() / 0.01, 0.5 * kGravity, 1e-9);
}

TEST(Mechanism, ReactionsOfASwingingLoopAddUpToTheMomentumOfAllParts) {
  SliderCrank machine(0.04, 0.15, 0.01);
  machine.model.timestep = 1e-4;
  Solver solver(machine.model);
  for (int k = 0; k < 3; ++k) solver.step();
  solver.clear_boundary_loads();
  const auto momentum = [&](const std::vector<FrameState>& from,
                            const std::vector<FrameState>& to) {
    Vec3 sum = Vec3::Zero();  // by differences, as reactions are defined
    for (std::size_t f = 0; f < from.size(); ++f) {
      const FreeBody& body = *machine.model.frames[f].free;
      const Vec3 arm = body.center - machine.model.frames[f].origin;
      sum += body.mass *
             (to[f].position + to[f].orientation * arm - from[f].position -
              from[f].orientation * arm) /
             1e-4;
    }
    return sum;
  };
  std::vector<FrameState> last = solver.frames();
  solver.step();
  std::vector<FrameState> now = solver.frames();
  const Vec3 start = momentum(last, now);
  solver.clear_boundary_loads();
  for (int k = 0; k < 2000; ++k) {
    last = solver.frames();
    solver.step();
  }
  now = solver.frames();
  const Vec3 change = momentum(last, now) - start, weight(0, 0, -0.6 * kGravity * 0.2);
  // The ground bears the joints of crank and piston.
  const Vec3 reactions = now[0].reaction_impulse + now[2].reaction_impulse;
  EXPECT_LT((reactions + weight - change).norm(), 1e-10);
  EXPECT_GT(solver.couplings()[0].impulse.norm(), 0.01);
}

TEST(Mechanism, GearsShareTheirInertiaByTheSquareOfTheRatio) {
  for (const double ratio : {-3.0, 0.5, 2.0}) {
    Model model = mechanism();
    const int a = add_mover(model, "a", 1, Vec3::Zero(), Vec3(1, 1e-3, 1), {hinge(Vec3::UnitY())});
    const int b = add_mover(model, "b", 1, Vec3(0.1, 0, 0), Vec3(1, 2e-3, 1),
                            {hinge(Vec3::UnitY())}, Vec3(0.1, 0, 0));
    Coupling gear = pin(a, b, Vec3::Zero());
    gear.kind = Coupling::Kind::gear;
    gear.ratio = ratio;
    model.couplings = {gear};
    drive_at(model, a, 1e6, 0.01);
    const Solver solver = run_for(model, 1e-4, 0.1);
    const double expected = 0.01 * 0.1 / (1e-3 + ratio * ratio * 2e-3);
    EXPECT_NEAR(rate(solver, a), expected, 1e-9 * expected);
    EXPECT_NEAR(coordinate(solver, b), ratio * coordinate(solver, a), 1e-14);
    EXPECT_NEAR(solver.couplings()[0].angular_impulse.y(), 2e-3 * ratio * expected, 1e-9);
  }
}

TEST(Mechanism, FollowerLiesOnTheCamAtEveryAngle) {
  Model model = mechanism();
  const int cam = add_mover(model, "cam", 1, Vec3::Zero(), Vec3::Ones(), {hinge(Vec3::UnitY())});
  const int rod = add_mover(model, "rod", 0.1, Vec3::Zero(), Vec3::Ones(), {slider(Vec3::UnitZ())});
  Coupling lift = pin(cam, rod, Vec3::Zero());
  lift.kind = Coupling::Kind::cam;
  lift.angles = {0, 1, 2, 3, 4, 5};
  lift.lifts = {0, 0, 0.01, 0.02, 0.02, 0.005};
  model.couplings = {lift};
  drive_at(model, cam, 2);
  model.timestep = 1e-3;
  Solver solver(model);
  double highest = 0, lowest = 0;
  for (int k = 0; k < 8000; ++k) {
    solver.step();
    const double angle = std::fmod(coordinate(solver, cam), 2 * pi), at = coordinate(solver, rod);
    highest = std::max(highest, at);
    lowest = std::min(lowest, at);
    for (std::size_t i = 0; i < lift.angles.size(); ++i)
      if (std::abs(angle - lift.angles[i]) < 1e-6) {
        EXPECT_NEAR(at, lift.lifts[i], 1e-8);
      }
    if (angle > 3 && angle < 4) {
      EXPECT_NEAR(at, 0.02, 1e-12);
    }
    if (angle < 1) {
      EXPECT_NEAR(at, 0, 1e-12);
    }
  }
  EXPECT_NEAR(highest, 0.02, 1e-12);
  EXPECT_NEAR(lowest, 0, 1e-12);
}

TEST(Mechanism, PointStaysInItsSlotAndWeldHoldsAll) {
  // A yoke: the crank's pin in a slot along z of a slide along x moves it as r cos(a).
  const double r = 0.03;
  Model model = mechanism();
  const int crank = add_bar(model, 0.1, Vec3::Zero(), Vec3(r, 0, 0), -1);
  const int yoke = add_mover(model, "yoke", 0.4, Vec3(r, 0, 0), Vec3::Ones(),
                             {slider(Vec3::UnitX())}, Vec3(r, 0, 0));
  const int tip = add_mover(model, "tip", 0.1, Vec3(0.2, 0, 0), Vec3::Ones(),
                            {slider(Vec3::UnitX()), slider(Vec3::UnitZ()), hinge(Vec3::UnitY())},
                            Vec3(0.2, 0, 0));
  Coupling slot = pin(yoke, crank, Vec3(r, 0, 0)), weld = pin(yoke, tip, Vec3(0.1, 0, 0));
  slot.kind = Coupling::Kind::slot;
  slot.direction = Vec3::UnitZ();
  weld.kind = Coupling::Kind::weld;
  model.couplings = {slot, weld};
  drive_at(model, crank, 9);
  model.timestep = 1e-4;
  Solver solver(model);
  for (int k = 0; k < 9000; ++k) {
    solver.step();
    const double x = r * std::cos(coordinate(solver, crank)) - r;
    ASSERT_NEAR(coordinate(solver, yoke), x, 1e-12);
    ASSERT_NEAR(coordinate(solver, tip, 0), x, 1e-11);
    ASSERT_NEAR(coordinate(solver, tip, 1), 0, 1e-11);
    ASSERT_NEAR(coordinate(solver, tip, 2), 0, 1e-10);
  }
}

TEST(Mechanism, FrictionHoldsAMechanismExactlyUntilItIsOvercome) {
  // Both bars horizontal: the joint of the upper one bears (m1/2 + m2) g l1 + m2 g l2/2.
  const double needed = kGravity * ((kM1 / 2 + kM2) * kL1 + kM2 * kL2 / 2),
               lower = kGravity * kM2 * kL2 / 2;
  for (const double part : {0.999, 1.001}) {
    Model model = double_pendulum();
    model.frames[0].free->joints[0].friction = part * needed;
    model.frames[1].free->joints[0].friction = 1.5 * lower;
    const Solver solver = run_for(model, 1e-4, 0.2);
    if (part > 1) {
      EXPECT_EQ(coordinate(solver, 0), 0);
      EXPECT_EQ(rate(solver, 0), 0);
    } else {
      EXPECT_LT(coordinate(solver, 0), -1e-4);
    }
    EXPECT_EQ(coordinate(solver, 1), 0);
  }
}

TEST(Mechanism, LimitStopsAndMotorStalls) {
  SliderCrank machine(0.04, 0.15, 0);
  auto& piston = machine.model.frames[static_cast<std::size_t>(machine.piston)].free->joints[0];
  piston.lower = -0.03;
  drive_at(machine.model, machine.crank, 5, 2);
  const Solver solver = run_for(machine.model, 1e-4, 1);
  EXPECT_NEAR(coordinate(solver, machine.piston), -0.03, 1e-9);
  EXPECT_NEAR(rate(solver, machine.crank), 0, 1e-6);
  EXPECT_GT(solver.frames()[static_cast<std::size_t>(machine.piston)].joints[0].limit_impulse, 1);
}

TEST(Mechanism, StandsOnAGroundThatIsMoved) {
  // As seen from a ground that turns and shakes, in a model where the ground is a heavy free body
  // with motors, which is the same motion by other equations.
  const auto motion = [](double speed) {
    Motion m;
    m.kind = Motion::Kind::rotation;
    m.axis = Vec3::UnitZ();
    m.angular_speed = speed;
    return m;
  };
  const auto build = [&](bool prescribed) {
    Model model = mechanism();
    MotionFrame ground;
    ground.name = "ground";
    if (prescribed) {
      ground.motions = {motion(6)};
      model.frames.push_back(ground);
    } else {
      add_mover(model, "ground", 1e3, Vec3::Zero(), Vec3::Ones(), {hinge(Vec3::UnitZ())});
      drive_at(model, 0, 6);
    }
    const int upper = add_bar(model, kM1, Vec3(0.1, 0, 0), Vec3(0.1 + kL1, 0, 0), 0);
    add_bar(model, kM2, Vec3(0.1 + kL1, 0, 0), Vec3(0.1 + kL1 + kL2, 0, 0), upper);
    return model;
  };
  // Both jump to their speed at the start, which leaves the bars the same.
  const Solver a = run_for(build(true), 5e-5, 0.4), b = run_for(build(false), 5e-5, 0.4);
  EXPECT_GT(std::abs(coordinate(a, 1)), 0.3);
  EXPECT_NEAR(coordinate(a, 1), coordinate(b, 1), 1e-4);
  EXPECT_NEAR(coordinate(a, 2), coordinate(b, 2), 1e-4);
}

TEST(Mechanism, LoopOnAMovedGroundLoadsItsPinAsOnAHeavyOneThatIsDriven) {
  const auto solve = [](bool prescribed) {
    Model model = mechanism();
    if (prescribed) {
      MotionFrame ground;
      ground.name = "ground";
      Motion& turn = ground.motions.emplace_back();
      turn.kind = Motion::Kind::rotation;
      turn.axis = Vec3::UnitZ();
      turn.angular_speed = 6;
      model.frames.push_back(ground);
    } else {
      add_mover(model, "ground", 1e3, Vec3::Zero(), Vec3::Constant(1e3), {hinge(Vec3::UnitZ())});
      drive_at(model, 0, 6);
    }
    const Vec3 start(0.1, 0, 0), end(0.14, 0, 0), wrist(0.28, 0, 0.02);
    const int crank = add_bar(model, 0.1, start, end, 0),
              rod = add_bar(model, 0.2, end, wrist, crank),
              piston = add_mover(model, "piston", 0.3, wrist, Vec3::Constant(1e-4),
                                 {slider(Vec3::UnitX())}, wrist);
    model.frames[static_cast<std::size_t>(piston)].parent = 0;
    model.couplings = {pin(rod, piston, wrist)};
    return run_for(model, 1e-4, 0.3);
  };
  const Solver a = solve(true), b = solve(false);
  EXPECT_GT(std::abs(coordinate(a, 1)), 0.1);
  EXPECT_GT(a.couplings()[0].impulse.norm(), 0.1);
  for (const int frame : {1, 2, 3}) EXPECT_NEAR(coordinate(a, frame), coordinate(b, frame), 1e-6);
  EXPECT_LT((a.couplings()[0].position - b.couplings()[0].position).norm(), 1e-6);
  EXPECT_LT((a.couplings()[0].impulse - b.couplings()[0].impulse).norm(), 1e-4);
  EXPECT_LT((a.frames()[3].reaction_impulse - b.frames()[3].reaction_impulse).norm(), 1e-4);
}

TEST(Mechanism, BodiesOfAMechanismTouchEachOther) {
  // A ball on the lower bar comes to rest on a ball of the cart.
  Model model = mechanism();
  const int cart =
      add_mover(model, "cart", 0.5, Vec3::Zero(), Vec3::Ones(), {slider(Vec3::UnitX())});
  const int bar = add_bar(model, 0.2, Vec3::Zero(), Vec3(0.2, 0, 0), cart);
  model.frames[static_cast<std::size_t>(bar)].free->joints[0].damping = 0.05;
  const int low = scenes::add_ball(model, "low", Vec3(0.15, 0, -0.04), 0.02, cart);
  const int high = scenes::add_ball(model, "high", Vec3(0.15, 0, 0.005), 0.02, bar);
  scenes::add_contact(model, low, high, 0, 0.3, 1e5);
  const Solver solver = run_for(model, 1e-5, 1);
  EXPECT_NEAR(rate(solver, bar), 0, 1e-5);
  EXPECT_NEAR(rate(solver, cart), 0, 1e-5);
  // Statics: the bar's weight about its hinge.
  const BoundaryContactState contact = solver.boundary_contacts()[0];
  const FrameState at = solver.frames()[static_cast<std::size_t>(bar)];
  const Vec3 weight_arm = at.orientation * Vec3(0.1, 0, 0);
  const Vec3 contact_force = solver.boundary_contacts()[0].force;
  const Vec3 touch = at.orientation * Vec3(0.15, 0, 0.005);
  EXPECT_NEAR(-touch.cross(contact_force).y(), weight_arm.cross(Vec3(0, 0, 0.2 * kGravity)).y(),
              1e-4);
  EXPECT_GT(contact.normal_force, 1);
}

TEST(Mechanism, ResumesBitForBit) {
  SliderCrank machine(0.04, 0.15, 0.01);
  drive_at(machine.model, machine.crank, 20, 1);
  machine.model.timestep = 1e-4;
  Solver whole(machine.model), first(machine.model), second(machine.model);
  for (int k = 0; k < 700; ++k) whole.step();
  for (int k = 0; k < 300; ++k) first.step();
  second.restore(first.save());
  for (int k = 0; k < 400; ++k) second.step();
  EXPECT_EQ(whole.save(), second.save());
}

TEST(Mechanism, IsRefusedWhereItCannotWork) {
  const auto message = [](const Model& model) {
    return test::error_if_any([&] { validate(model); });
  };
  {
    Model model = double_pendulum();  // two slides along one direction
    model.timestep = 1e-4;
    EXPECT_EQ(message(model), "");
    model.frames[1].free->joints = {slider(Vec3::UnitX()), slider(Vec3::UnitX())};
    EXPECT_THAT(message(model), testing::HasSubstr("cannot be moved along its axes"));
  }
  {
    Model model = double_pendulum();
    model.timestep = 1e-4;
    model.couplings = {pin(0, 0, Vec3::Zero())};
    EXPECT_THAT(message(model), testing::HasSubstr("ties a body to itself"));
    model.couplings = {pin(-1, -1, Vec3::Zero())};
    EXPECT_THAT(message(model), testing::HasSubstr("a force can move"));
    model.couplings = {pin(0, 7, Vec3::Zero())};
    EXPECT_THAT(message(model), testing::HasSubstr("do not exist"));
  }
  {
    Model model = double_pendulum();
    model.timestep = 1e-4;
    MotionFrame moved;
    moved.name = "moved";
    model.frames.push_back(moved);
    model.couplings = {pin(2, 1, Vec3::Zero())};
    EXPECT_THAT(message(model), testing::HasSubstr("do not stand on the same frame"));
  }
}

}  // namespace
}  // namespace firn
