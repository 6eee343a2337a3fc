// Motion frames and free bodies against closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "solver/dynamics/joint_loads.h"
#include "tests/support/error_of.h"
#include "validation/verification/fixtures/mechanisms.h"
#include "validation/verification/fixtures/scenes.h"

namespace firn {
namespace {

using scenes::hinge;
using scenes::kGravity;
using scenes::slider;
using std::numbers::pi;

// A frame and nothing else; a particle waits, so that there is a model.
Model scene(const MotionFrame& frame, double timestep = 1e-4) {
  Model model = scenes::empty(scenes::law(0.3, 0.3), scenes::law(0.3, 0.3));
  scenes::add_particles(model, scenes::add_shape(model, scenes::crescent()));
  model.frames = {frame};
  model.timestep = timestep;
  return model;
}

MotionFrame free_frame(double mass, const Vec3& center, const Mat3& inertia,
                       std::vector<Joint> axes) {
  MotionFrame frame;
  frame.name = "free";
  frame.free = FreeBody{mass, center, inertia, std::move(axes), false};
  return frame;
}

// A bob of 0.3 kg, 0.2 m off a hinge along y, with an inertia about its center; drawn at `angle`
// from straight down.
constexpr double kMass = 0.3, kArm = 0.2, kOwn = 1e-3, kAboutHinge = kOwn + kMass * kArm * kArm;
MotionFrame pendulum(double angle, const Vec3& pivot = Vec3::Zero()) {
  MotionFrame frame =
      free_frame(kMass, pivot + kArm * Vec3(std::sin(angle), 0, -std::cos(angle)),
                 Mat3(Vec3(2e-3, kOwn, 3e-3).asDiagonal()), {hinge(-Vec3::UnitY())});
  frame.origin = pivot;
  return frame;
}

double coordinate(const Solver& solver, std::size_t axis = 0) {
  return solver.frames().back().joints.at(axis).coordinate;
}
double rate(const Solver& solver, std::size_t axis = 0) {
  return solver.frames().back().joints.at(axis).rate;
}

TEST(FreeBody, PendulumSwingsWithThePeriodOfTheEllipticIntegral) {
  const double start = 1.0;  // rad
  Solver solver(scene(pendulum(start)));
  const double small = 2 * pi * std::sqrt(kAboutHinge / (kMass * kGravity * kArm));
  const double period = small * 2 / pi * std::comp_ellint_1(std::sin(0.5 * start));
  // It crosses the vertical a quarter of a period after its release.
  double crossed = 0, before = start;
  while (crossed == 0 && solver.time() < 2) {
    const double t = solver.time();
    solver.step();
    const double now = start + coordinate(solver);
    if (now <= 0) crossed = t + solver.model().timestep * before / (before - now);
    before = now;
  }
  EXPECT_NEAR(crossed, 0.25 * period, 1e-6);
  // And is back with its full height after the period.
  while (solver.time() < period - 0.5e-4) solver.step();
  EXPECT_NEAR(coordinate(solver), 0, 1e-6);
  EXPECT_NEAR(rate(solver), 0, 5e-3);
}

TEST(FreeBody, SliderOnSpringAndDamperFollowsTheClosedForm) {
  Joint axis = slider(Vec3::UnitX());
  axis.stiffness = 50;
  axis.damping = 0.8;
  axis.spring_reference = 0.1;
  Solver solver(scene(free_frame(0.5, {0, 0, 0.3}, Mat3::Identity(), {axis})));
  scenes::run(solver, 1.0);
  const double decay = 0.8 / (2 * 0.5), omega = std::sqrt(50 / 0.5 - decay * decay);
  const double expected =
      0.1 - 0.1 * std::exp(-decay) * (std::cos(omega) + decay / omega * std::sin(omega));
  EXPECT_NEAR(coordinate(solver), expected, 2e-5);
}

TEST(FreeBody, FrictionHoldsUpToItsLimitExactlyAndTakesItBeyond) {
  const double weight = 0.5 * kGravity;
  for (const double share : {1.001, 0.6}) {
    Joint axis = slider(Vec3::UnitZ());
    axis.friction = share * weight;
    Solver solver(scene(free_frame(0.5, Vec3::Zero(), Mat3::Identity(), {axis})));
    scenes::run(solver, 0.2);
    const double fall = share > 1 ? 0 : 0.5 * (1 - share) * kGravity * 0.2 * 0.2;
    EXPECT_NEAR(coordinate(solver), -fall, 1e-12 + 1e-9 * fall);
  }
}

TEST(FreeBody, DriveSpeedsUpByItsLimitThenHoldsItsSpeedExactly) {
  const double inertia = 2e-3, limit = 0.04, speed = 4;
  Joint axis = hinge(Vec3::UnitX());
  Motor motor;
  motor.speed = speed;
  motor.max_load = limit;
  axis.motors = {motor};
  Solver solver(scene(free_frame(1, Vec3::Zero(), inertia * Mat3::Identity(), {axis})));
  scenes::run(solver, 0.1);
  EXPECT_NEAR(rate(solver), limit / inertia * 0.1, 1e-9);
  EXPECT_NEAR(solver.frames()[0].joints[0].motor_impulse, limit * 0.1, 1e-12);
  EXPECT_TRUE(solver.frames()[0].driven);
  scenes::run(solver, 0.2);
  EXPECT_NEAR(rate(solver), speed, 1e-12);
  solver.clear_boundary_loads();
  scenes::run(solver, 0.1);
  EXPECT_NEAR(solver.frames()[0].joints[0].motor_impulse, 0, 1e-12);  // nothing resists
}

TEST(FreeBody, DriveWithATargetGoesThereHoldsAndLetsGo) {
  // The sensing arm: lifted by 45 degrees, held, and let fall onto its stop, twice.
  MotionFrame frame = free_frame(0.04, {0.06, 0, 0}, 6e-5 * Mat3::Identity(), {});
  Joint axis = hinge(-Vec3::UnitY());
  axis.lower = 0;
  Motor lift;
  lift.speed = 75 * kDegToRad / 0.6;
  lift.target = 45 * kDegToRad;
  lift.stop = 1.2;
  lift.period = 2;
  axis.motors = {lift};
  frame.free->joints = {axis};
  Solver solver(scene(frame));
  scenes::run(solver, 1.19);
  EXPECT_NEAR(coordinate(solver), 45 * kDegToRad, 1e-9);
  scenes::run(solver, 0.8);
  EXPECT_FALSE(solver.frames()[0].driven);
  EXPECT_NEAR(coordinate(solver), 0, 1e-12);
  EXPECT_NEAR(rate(solver), 0, 1e-12);
  // At rest the stop carries the arm's moment.
  solver.clear_boundary_loads();
  scenes::run(solver, 0.005);
  EXPECT_NEAR(solver.frames()[0].joints[0].limit_impulse, 0.04 * kGravity * 0.06 * 0.005, 1e-9);
  scenes::run(solver, 1.19);
  EXPECT_NEAR(coordinate(solver), 45 * kDegToRad, 1e-9);
}

TEST(FreeBody, StopTurnsTheMotionRoundByItsRestitution) {
  Joint axis = slider(Vec3::UnitZ());
  axis.lower = -0.05;
  axis.limit_restitution = 0.4;
  Solver solver(scene(free_frame(0.5, Vec3::Zero(), Mat3::Identity(), {axis})));
  double lowest = 0, fastest_up = 0;
  for (int i = 0; i < 1500; ++i) {
    solver.step();
    lowest = std::min(lowest, coordinate(solver));
    fastest_up = std::max(fastest_up, rate(solver));
  }
  EXPECT_GE(lowest, -0.05 - 1e-12);
  EXPECT_NEAR(fastest_up, 0.4 * std::sqrt(2 * kGravity * 0.05), 2e-3);
}

// The forces at both ends of a bearing, from the balance of forces and moments.
double force_of_both_ends(const Vec3& axis, double length, const JointLoad& load) {
  const Vec3 x = axis.unitOrthogonal(), y = axis.cross(x);
  Eigen::Matrix4d balance;  // of the components of both ends along x and y
  Eigen::Vector4d wanted;
  int row = 0;
  for (const Vec3& e : {x, y}) {
    const auto force = [&](const Vec3& f) { return f.dot(e); };
    const auto moment = [&](double at, const Vec3& f) { return (at * axis).cross(f).dot(e); };
    balance.row(row) << force(x), force(y), force(x), force(y);
    wanted[row++] = load.force.dot(e);
    balance.row(row) << moment(length / 2, x), moment(length / 2, y), moment(-length / 2, x),
        moment(-length / 2, y);
    wanted[row++] = load.torque.dot(e);
  }
  const Eigen::Vector4d ends = balance.fullPivLu().solve(wanted);
  return ends.head<2>().norm() + ends.tail<2>().norm();
}

// The joints of a body whose center of mass is off its hinge: a force along one accelerates the
// others, too.
std::vector<Joint> joints_in_order(std::vector<Joint> joints,
                                   const std::vector<std::size_t>& order) {
  std::vector<Joint> out;
  for (const std::size_t k : order) out.push_back(std::move(joints[k]));
  return out;
}
MotionFrame body_off_its_hinge(std::vector<Joint> joints) {
  return free_frame(0.5, Vec3(0.08, 0, -0.06), Mat3(Vec3(8e-4, 1e-3, 6e-4).asDiagonal()),
                    std::move(joints));
}

TEST(FreeBody, FrictionHoldsSeveralJointsAtOnce) {
  Joint slide = slider(Vec3::UnitX()), turn = hinge(Vec3::UnitY());
  slide.friction = 4;
  turn.friction = 0.5;  // more than the weight of 0.5 kg on an arm of 0.08 m
  for (const bool slide_first : {true, false}) {
    Solver solver(scene(body_off_its_hinge(
        joints_in_order({slide, turn}, slide_first ? std::vector<std::size_t>{0, 1}
                                                   : std::vector<std::size_t>{1, 0}))));
    for (int k = 0; k < 500; ++k) solver.step();
    for (const std::size_t k : {std::size_t{0}, std::size_t{1}}) {
      EXPECT_EQ(coordinate(solver, k), 0);
      EXPECT_EQ(rate(solver, k), 0);
    }
  }
}

TEST(FreeBody, SeveralLimitsHoldAtOnce) {
  Joint across = slider(Vec3::UnitX()), turn = hinge(-Vec3::UnitY());
  across.lower = -1e-3;
  across.upper = 2e-3;
  turn.lower = -0.1;
  turn.upper = 0.2;
  MotionFrame frame = body_off_its_hinge({across, turn});
  Solver solver(scene(frame));
  for (int k = 0; k < 5000; ++k) {
    solver.step();
    for (const std::size_t j : {std::size_t{0}, std::size_t{1}}) {
      const Joint& joint = frame.free->joints[j];
      ASSERT_GE(coordinate(solver, j), joint.lower - 1e-15) << k;
      ASSERT_LE(coordinate(solver, j), joint.upper + 1e-15) << k;
    }
  }
  // At rest on the limit of the hinge. The impulses of the limits balance gravity.
  EXPECT_EQ(coordinate(solver, 1), turn.lower);
  EXPECT_NEAR(rate(solver, 0), 0, 1e-12);
  EXPECT_NEAR(rate(solver, 1), 0, 1e-12);
}

// Seeded bodies with a hinge and two slides whose friction, motors and limits are drawn.
TEST(FreeBody, TheOrderOfItsJointsDoesNotMatter) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  const std::vector<std::vector<std::size_t>> orders = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                                        {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  for (int member = 0; member < 40; ++member) {
    std::vector<Joint> joints = {
        slider(Vec3::UnitX()), slider(Vec3(unit(random) - 0.5, unit(random) - 0.5, 1).normalized()),
        hinge(-Vec3::UnitY())};
    for (std::size_t k = 0; k < joints.size(); ++k) {
      const bool turns = k == 2;
      Joint& joint = joints[k];
      joint.stiffness = turns ? 2 : 400;  // N m/rad, N/m
      if (unit(random) < 0.6) joint.friction = (turns ? 0.3 : 4) * unit(random);
      if (unit(random) < 0.5) joint.lower = -(turns ? 0.1 : 3e-3) * unit(random);
      if (unit(random) < 0.5) joint.upper = (turns ? 0.1 : 3e-3) * unit(random);
      if (unit(random) < 0.4) {
        Motor motor;
        motor.speed = (turns ? 2 : 0.05) * (unit(random) - 0.5);
        motor.max_load = (turns ? 0.4 : 5) * unit(random);
        joint.motors = {motor};
      }
    }
    std::vector<double> expected;
    for (const std::vector<std::size_t>& order : orders) {
      Solver solver(scene(body_off_its_hinge(joints_in_order(joints, order))));
      for (int k = 0; k < 400; ++k) solver.step();
      std::vector<double> found(3);
      for (std::size_t k = 0; k < 3; ++k) found[order[k]] = coordinate(solver, k);
      if (expected.empty()) expected = found;
      for (std::size_t k = 0; k < 3; ++k)
        EXPECT_NEAR(found[k], expected[k], 1e-9) << "member " << member << ", joint " << k;
    }
  }
}

// Slides along gravity and hinges through the center of mass, with friction F and a motor of at
// most M. The rate u after a step minimizes inertia (u - u0)^2 / 2 + dt (F |u| + M |u - speed|).
TEST(FreeBody, FrictionAndAMotorOfAJointActTogether) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(0, 1);
  constexpr double mass = 0.5, about = 2e-3, weight = mass * kGravity;
  int sticking = 0;
  for (int member = 0; member < 60; ++member) {
    const bool turns = member % 2 == 1;
    const double inertia = turns ? about : mass, load = turns ? 0 : -weight;
    Joint joint = turns ? hinge(Vec3::UnitX()) : slider(Vec3::UnitZ());
    joint.friction = turns ? 0.03 * unit(random) : weight * (0.5 + 1.5 * unit(random));
    Motor motor;
    motor.speed = 2 * unit(random) - 1;
    motor.max_load = (turns ? 0.03 : weight) * unit(random);
    joint.motors = {motor};
    Solver solver(
        scene(free_frame(mass, Vec3::Zero(), Mat3(Vec3::Constant(about).asDiagonal()), {joint})));
    const double dt = solver.model().timestep, f = dt * joint.friction / inertia,
                 m = dt * motor.max_load / inertia;
    double expected = 0;
    for (int k = 0; k < 200; ++k) {
      const double before = expected, u0 = expected + dt * load / inertia;
      const auto cost = [&](double u) {
        return 0.5 * (u - u0) * (u - u0) + f * std::abs(u) + m * std::abs(u - motor.speed);
      };
      expected = std::min({0.0, motor.speed, u0 + f + m, u0 + f - m, u0 - f + m, u0 - f - m},
                          [&](double a, double b) { return cost(a) < cost(b); });
      solver.step();
      // The half-kicks differ from a whole step where a rate reaches zero or the target.
      ASSERT_NEAR(rate(solver), expected, f + m + dt * std::abs(load) / inertia)
          << "member " << member << " step " << k;
      if (expected == 0 && before == 0) {
        ASSERT_NEAR(coordinate(solver), 0, 1e-15) << "member " << member << " step " << k;
      }
    }
    if (expected == motor.speed) {
      EXPECT_NEAR(rate(solver), motor.speed, 1e-15);
    }
    sticking += expected == 0 ? 1 : 0;
  }
  EXPECT_GE(sticking, 10);
  EXPECT_LE(sticking, 50);
}

// Friction on a slide, and a motor of a stage on a hinge that inertia couples to it.
TEST(FreeBody, AMotorOfAStageDoesNotMakeAStickingJointCreep) {
  Joint slide = slider(Vec3::UnitX()), turn = hinge(Vec3::UnitY());
  slide.friction = 5;
  Motor motor;
  motor.speed = 0.5;
  motor.max_load = 0.05;
  std::vector<double> ends;
  for (const bool slides_first : {true, false}) {
    const std::vector<Joint> joints =
        slides_first ? std::vector<Joint>{slide, turn} : std::vector<Joint>{turn, slide};
    Solver solver(
        scene(free_frame(0.5, {0, 0, -0.05}, Mat3(Vec3::Constant(1e-3).asDiagonal()), joints)));
    solver.add_motor(0, slides_first ? 1 : 0, motor);
    for (int k = 0; k < 2000; ++k) solver.step();
    EXPECT_NEAR(coordinate(solver, slides_first ? 0 : 1), 0, 1e-15);
    ends.push_back(coordinate(solver, slides_first ? 1 : 0));
    EXPECT_GT(ends.back(), 0.01);
  }
  EXPECT_NEAR(ends[0], ends[1], 1e-12);
}

TEST(FreeBody, FrictionOfABearingFollowsWhatItBears) {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> any(-1, 1), positive(0.01, 1);
  const auto vector = [&] { return Vec3(any(random), any(random), any(random)); };
  for (int i = 0; i < 500; ++i) {
    const Vec3 direction = vector().normalized();
    const JointLoad load{10 * vector(), vector()};
    Joint joint = i % 2 == 0 ? hinge(direction) : slider(direction);
    joint.friction = positive(random);
    EXPECT_EQ(friction_limit(joint, direction, load), joint.friction);
    joint.friction_coefficient = positive(random);
    joint.bearing_radius = joint.kind == Joint::Kind::rotation ? positive(random) : 0;
    const double along = std::abs(load.force.dot(direction));
    const auto expected = [&](double across) {
      const double borne =
          joint.kind == Joint::Kind::rotation ? joint.bearing_radius * (across + along) : across;
      return joint.friction + joint.friction_coefficient * borne;
    };
    EXPECT_NEAR(friction_limit(joint, direction, load),
                expected((load.force - load.force.dot(direction) * direction).norm()), 1e-12);
    joint.bearing_length = positive(random);
    EXPECT_NEAR(friction_limit(joint, direction, load),
                expected(force_of_both_ends(direction, joint.bearing_length, load)), 1e-10);
  }
}

TEST(FreeBody, TorqueFreeBodyKeepsItsMomentumAndEnergy) {
  // Set spinning by the first step of its parent frame, about an axis that is none of its principal
  // axes.
  const Vec3 inertia(1e-3, 2e-3, 3e-3);
  MotionFrame carrier;
  carrier.name = "carrier";
  Motion rotation;
  rotation.kind = Motion::Kind::rotation;
  rotation.axis = Vec3(0.1, 1, 0.1).normalized();
  rotation.angular_speed = 10;
  rotation.stop = 1e-5;
  carrier.motions = {rotation};
  MotionFrame body = free_frame(1, Vec3::Zero(), inertia.asDiagonal(), {});
  body.parent = 0;
  body.free->free_rotation = true;
  Model model = scene(carrier, 1e-5);
  model.frames.push_back(body);
  model.gravity = Vec3::Zero();
  Solver solver(model);
  // A body without bearings does not feel its carrier turn; the first step gives it no spin.
  scenes::run(solver, 0.01);
  EXPECT_LT(solver.frames()[1].angular_velocity.norm(), 1e-9);
  // One that falls and may turn falls like any other, and does not turn.
  for (const int along : {0, 1, 2})
    model.frames[1].free->joints.push_back(slider(Vec3::Unit(along)));
  model.frames[1].free->center = {0.01, 0.02, 0.03};
  model.frames[0].motions.clear();
  model.gravity = {0, 0, -kGravity};
  Solver falling(model);
  scenes::run(falling, 0.1);
  EXPECT_NEAR(coordinate(falling, 2), -0.5 * kGravity * 0.01, 1e-9);
  EXPECT_LT(falling.frames()[1].angular_velocity.norm(), 1e-9);
}

TEST(FreeBody, PendulumFeelsItsPivotBeingMoved) {
  // A pivot that starts at once hits the pendulum: I w = m l v.
  MotionFrame cart;
  cart.name = "cart";
  Motion go;
  go.velocity = {0.3, 0, 0};
  go.start = 0.01;
  cart.motions = {go};
  MotionFrame hung = pendulum(0);
  hung.parent = 0;
  Model model = scene(cart);
  model.frames.push_back(hung);
  model.gravity = Vec3::Zero();
  Solver solver(model);
  scenes::run(solver, 0.0095);
  EXPECT_DOUBLE_EQ(coordinate(solver), 0);
  scenes::run(solver, 0.001);
  EXPECT_NEAR(std::abs(rate(solver)), kMass * kArm * 0.3 / kAboutHinge, 1e-6);
  EXPECT_LT(solver.frames()[1].angular_velocity.y(), 10);
  // One under a steady acceleration hangs at atan(a / g): at rest there, it stays.
  Motion ramp;
  ramp.kind = Motion::Kind::translation;
  ramp.profile = Motion::Profile::ramp;
  ramp.axis = Vec3::UnitX();
  ramp.end_rate = 4;
  ramp.ramp_time = 2;
  model.frames[0].motions = {ramp};
  model.frames[1] = pendulum(-std::atan(2 / kGravity));
  model.frames[1].parent = 0;
  model.gravity = {0, 0, -kGravity};
  Solver leaning(model);
  scenes::run(leaning, 1);
  EXPECT_NEAR(coordinate(leaning), 0, 1e-5);
}

TEST(FreeBody, PendulumOnATurntableSwingsAboutTheOutwardDirection) {
  // Hinge along z at radius R of a table that turns with W: I q'' = -m l R W^2 sin q.
  constexpr double kRadius = 0.5, kAngularSpeed = 6;
  MotionFrame table;
  table.name = "table";
  Motion turn;
  turn.kind = Motion::Kind::rotation;
  turn.angular_speed = kAngularSpeed;
  table.motions = {turn};
  MotionFrame hung = free_frame(kMass, {kRadius + kArm * std::cos(0.1), kArm * std::sin(0.1), 0},
                                Mat3(Vec3(2e-3, 1e-3, kOwn).asDiagonal()), {hinge(Vec3::UnitZ())});
  hung.origin = {kRadius, 0, 0};
  hung.parent = 0;
  Model model = scene(table);
  model.frames.push_back(hung);
  // The table has turned for ever: what its start gives the pendulum, a hand takes away.
  Solver solver(model);
  solver.step();
  const double kicked = rate(solver);
  EXPECT_LT(kicked, -kAngularSpeed);  // the bob wants to stay where it is
  double greatest = 0;
  // Its energy in the turning frame is conserved: (1/2) I q'^2 - m l R W^2 cos q.
  const auto energy = [&] {
    const double q = 0.1 + coordinate(solver), w = rate(solver);
    return 0.5 * kAboutHinge * w * w -
           kMass * kArm * kRadius * kAngularSpeed * kAngularSpeed * std::cos(q);
  };
  const double start = energy();
  for (int i = 0; i < 10000; ++i) {
    solver.step();
    greatest = std::max(greatest, std::abs(energy() - start));
  }
  EXPECT_LT(greatest, 2e-3 * std::abs(start));
}

// A plate of 0.2 x 0.1 m on the frame, its top at z = 0.
void add_plate(Model& model, int frame, const Vec3& center) {
  scenes::add_panel(model, "plate", center - Vec3(0.1, 0.05, 0.02), center + Vec3(0.1, 0.05, 0));
  model.boundaries.back().frame = frame;
}

TEST(FreeBody, CubeOnAHingedPlateBendsItsSpring) {
  // Hinge along y at x = 0; the cube lies at x = 0.15: k q = m g x cos q, and the plate is hinged
  // at its center of mass.
  Joint axis = hinge(Vec3::UnitY());
  axis.stiffness = 2;
  axis.damping = 0.05;
  MotionFrame frame = free_frame(0.5, Vec3::Zero(), 2e-3 * Mat3::Identity(), {axis});
  frame.name = "plate";
  Model model = scenes::empty(scenes::law(0.5, 0.3), scenes::law(0.5, 0.3));
  const double mass = 0.02, edge = 0.02;
  const int cube = scenes::add_shape(
      model, make_box(Vec3::Constant(edge), scenes::ice_options(mass, 2e4, 5e-4)));
  scenes::add_particles(model, cube);
  model.frames = {frame};
  add_plate(model, 0, {0.1, 0, 0});
  model.timestep = 2e-5;
  Solver solver(model);
  solver.insert(0, {0.15, 0, 0.5 * edge}, Quat::Identity(), Vec3::Zero(), Vec3::Zero());
  scenes::run(solver, 1.5);
  const double q = coordinate(solver);
  const Vec3 arm = solver.particles().position[0];
  EXPECT_NEAR(2 * q, mass * kGravity * arm.x(), 1e-4 * 2 * q);
  EXPECT_GT(q, 0.01);
  // What is left swings on the springs of friction, which hold without damping.
  EXPECT_LT(solver.particles().velocity[0].norm(), 3e-4);
}

TEST(FreeBody, CollisionWithASliderKeepsMomentumAndItsRestitution) {
  const double m = 0.02, heavy = 0.05, speed = 0.5, e = 0.3;
  MotionFrame frame = free_frame(heavy, Vec3::Zero(), Mat3::Identity(), {slider(Vec3::UnitX())});
  frame.name = "slider";
  Model model = scenes::empty(scenes::law(0, e), scenes::law(0, e));
  model.gravity = Vec3::Zero();
  const int cube =
      scenes::add_shape(model, make_box(Vec3::Constant(0.02), scenes::ice_options(m, 2e4, 5e-4)));
  scenes::add_particles(model, cube);
  model.frames = {frame};
  add_plate(model, 0, {0, 0, 0.01});
  model.timestep = 2e-6;
  Solver solver(model);
  solver.insert(0, {-0.115, 0, 0}, Quat::Identity(), {speed, 0, 0}, Vec3::Zero());
  scenes::run(solver, 0.03);
  const double cube_after = solver.particles().velocity[0].x(), plate_after = rate(solver);
  EXPECT_NEAR(m * cube_after + heavy * plate_after, m * speed, 1e-12);
  EXPECT_NEAR((plate_after - cube_after) / speed, e, 0.006);  // a little above: the unloading floor
  EXPECT_GT(plate_after, 0.1);
  // What the plate took is the work that boundaries did, taken from the cube.
  // (to the first order in the time step: forces meet the velocity of the half step before them).
  const double taken = 0.5 * heavy * plate_after * plate_after;
  EXPECT_NEAR(-solver.energy().boundary_work, taken, 3e-3 * taken);
}

TEST(MotionFrames, CarryEachOther) {
  // A carriage that moves along x, a wheel on it that turns about y, a pod on the wheel's rim that
  // turns back: the pod stays upright on a cycloid.
  const double v = 0.3, w = 5, radius = 0.1;
  Motion go, turn, back;
  go.velocity = {v, 0, 0};
  turn.kind = back.kind = Motion::Kind::rotation;
  turn.axis = back.axis = Vec3::UnitY();
  turn.angular_speed = w;
  back.angular_speed = -w;
  turn.center = {0, 0, 1};
  back.center = {radius, 0, 1};
  MotionFrame carriage, wheel, pod;
  carriage.name = "carriage";
  carriage.motions = {go};
  wheel.name = "wheel";
  wheel.parent = 0;
  wheel.origin = {0, 0, 1};
  wheel.motions = {turn};
  pod.name = "pod";
  pod.parent = 1;
  pod.origin = {radius, 0, 1};
  pod.motions = {back};
  Model model = scene(carriage);
  model.frames = {carriage, wheel, pod};
  add_plate(model, 2, {radius, 0, 1});
  Solver solver(model);
  scenes::run(solver, 0.7);
  const double a = w * 0.7;
  const BoundaryState plate = solver.boundaries()[0];
  const Vec3 rim(v * 0.7 + radius * std::cos(a), 0, 1 - radius * std::sin(a));
  const Vec3 offset = model.boundaries[0].origin - pod.origin;  // of the panel's own origin
  EXPECT_LT((plate.position - rim - offset).norm(), 1e-9);
  EXPECT_NEAR(std::abs(plate.orientation.w()), 1, 1e-12);
  EXPECT_LT(plate.angular_velocity.norm(), 1e-9);
  const Vec3 velocity(v - w * radius * std::sin(a), 0, -w * radius * std::cos(a));
  EXPECT_LT((plate.velocity - velocity).norm(), 1e-3);
}

TEST(MotionFrames, BoundaryMovesOnTopOfItsFrame) {
  Motion go, rotation;
  go.velocity = {0, 0.2, 0};
  rotation.kind = Motion::Kind::rotation;
  rotation.angular_speed = 3;
  rotation.center = {0.5, 0, 0};
  MotionFrame frame;
  frame.name = "lift";
  frame.origin = {7, 8, 9};  // where it is drawn does not matter
  frame.motions = {go};
  Model model = scene(frame);
  scenes::add_panel(model, "panel", {0.6, -0.1, -0.1}, {0.9, 0.1, 0.1});
  model.boundaries[0].frame = 0;
  model.boundaries[0].motions = {rotation};
  const Vec3 arm = model.boundaries[0].origin - rotation.center;
  Solver solver(model);
  scenes::run(solver, 0.4);
  // The center that it turns about goes along with the frame.
  const Quat turned(Eigen::AngleAxisd(3 * 0.4, Vec3::UnitZ()));
  const BoundaryState panel = solver.boundaries()[0];
  EXPECT_LT((panel.position - (rotation.center + Vec3(0, 0.08, 0) + turned * arm)).norm(), 1e-10);
  EXPECT_LT(panel.orientation.angularDistance(turned), 1e-9);
  EXPECT_LT((panel.velocity - Vec3(0, 0.2, 0) - Vec3(0, 0, 3).cross(turned * arm)).norm(), 1e-3);
  EXPECT_LT((panel.angular_velocity - Vec3(0, 0, 3)).norm(), 1e-9);
}

TEST(MotionFrames, RunsGoOnFromTheirState) {
  const auto make = [] {
    MotionFrame frame = pendulum(1.2, {0, 0, 0.5});
    Joint& axis = frame.free->joints[0];
    axis.friction = 0.01;
    axis.upper = 0;
    Model model = scene(frame);
    add_plate(model, 0, {0, 0, 0.3});
    return model;
  };
  Solver whole(make()), first(make());
  Motor late;
  late.start = 0.15;
  late.stop = 0.2;
  late.period = 0.1;
  late.speed = -2;
  late.max_load = 0.3;
  Motion swing;
  swing.profile = Motion::Profile::table;
  swing.times = {0, 0.1};
  swing.positions = {0, 0.01};
  for (Solver* s : {&whole, &first}) {
    s->add_motor(0, 0, late);
    s->add_motion(0, swing);
  }
  scenes::run(whole, 0.4);
  scenes::run(first, 0.17);
  Solver second(make());
  second.restore(first.save());
  EXPECT_EQ(second.hash(), first.hash());
  while (second.steps() < whole.steps()) second.step();
  EXPECT_EQ(second.hash(), whole.hash());
}

TEST(MotionFrames, AreRefusedWhereTheyCannotWork) {
  const auto complaint = [](const std::vector<MotionFrame>& frames) {
    Model model = scene(frames[0]);
    model.frames = frames;
    return test::error_if_any([&] { Solver solver(model); });
  };
  MotionFrame arm = pendulum(0.1);
  EXPECT_EQ(complaint({arm}), "");
  MotionFrame second = pendulum(0.2);
  second.parent = 0;
  EXPECT_EQ(complaint({arm, second}), "");
  MotionFrame moved;
  moved.name = "moved";
  moved.parent = 0;
  moved.motions.push_back({});
  EXPECT_NE(complaint({arm, moved}).find("has motions on the free frame"), std::string::npos);
  arm.free->joints.push_back(hinge(Vec3::UnitX()));
  EXPECT_NE(complaint({arm}).find("more than one axis"), std::string::npos);
  arm.free->joints = {slider(Vec3::UnitX()), slider(Vec3::UnitX())};
  EXPECT_NE(complaint({arm}).find("two of them are the same"), std::string::npos);
  arm.free->joints.clear();
  EXPECT_NE(complaint({arm}).find("no joint"), std::string::npos);
  arm = pendulum(0.1);
  arm.free->mass = 0;
  EXPECT_NE(complaint({arm}).find("mass"), std::string::npos);
  arm = pendulum(0.1);
  arm.motions.push_back({});
  EXPECT_NE(complaint({arm}).find("free and has motions"), std::string::npos);
}

TEST(MotionFrames, ALightFreeBodyShortensTheTimeStep) {
  MotionFrame frame = free_frame(0.002, Vec3::Zero(), Mat3::Identity(), {slider(Vec3::UnitX())});
  Model model = scene(frame);
  add_plate(model, -1, Vec3::Zero());
  model.boundaries[0].rigid = true;
  const double fixed = advise_timestep(model, 10).timestep;
  model.boundaries[0].frame = 0;
  const double light = advise_timestep(model, 10).timestep;
  // Quarter periods go with the square root of the effective mass.
  const double mass = model.shapes[0].mass;
  EXPECT_NEAR(light / fixed, std::sqrt(0.002 / (mass + 0.002)), 1e-6);
}

TEST(Motions, CoverTheWayOfTheirCourse) {
  Motion ramp;
  ramp.kind = Motion::Kind::rotation;
  ramp.profile = Motion::Profile::ramp;
  ramp.start = 1;
  ramp.stop = 5;
  ramp.rate = 1;
  ramp.end_rate = 3;
  ramp.ramp_time = 2;
  EXPECT_DOUBLE_EQ(ramp.displacement(0, 1), 0);
  EXPECT_DOUBLE_EQ(ramp.displacement(1, 2), 4);  // mean rate 2
  EXPECT_DOUBLE_EQ(ramp.displacement(0, 9), 4 + 3 * 2);
  EXPECT_DOUBLE_EQ(ramp.displacement(2, 0.5) + ramp.displacement(2.5, 0.5),
                   ramp.displacement(2, 1));

  Motion swing;
  swing.profile = Motion::Profile::sinusoidal;
  swing.amplitude = 0.02;
  swing.frequency = 5;
  EXPECT_NEAR(swing.displacement(0, 0.05), 0.02, 1e-15);
  EXPECT_NEAR(swing.displacement(0, 0.2), 0, 1e-15);

  Motion table;
  table.profile = Motion::Profile::table;
  table.start = 10;
  table.times = {0, 1, 4};
  table.positions = {5, 6, 0};  // only differences count
  EXPECT_DOUBLE_EQ(table.displacement(10, 1), 1);
  EXPECT_DOUBLE_EQ(table.displacement(11, 1.5), -3);
  EXPECT_DOUBLE_EQ(table.displacement(14, 10), 0);

  Motion shake;
  shake.kind = Motion::Kind::rotation;
  shake.angular_speed = 2;
  shake.start = 1;
  shake.stop = 1.5;
  shake.period = 2;
  EXPECT_DOUBLE_EQ(shake.displacement(0, 1), 0);
  EXPECT_DOUBLE_EQ(shake.displacement(1, 1), 1);
  EXPECT_DOUBLE_EQ(shake.displacement(2, 1), 0);
  EXPECT_DOUBLE_EQ(shake.displacement(3.25, 1), 0.5);
  EXPECT_DOUBLE_EQ(shake.displacement(2.5, 0.75), 0.5);  // across the border of two periods
  shake.end = 4;
  EXPECT_DOUBLE_EQ(shake.displacement(5, 1), 0);
  EXPECT_TRUE(shake.acts(3.2));
  EXPECT_FALSE(shake.acts(3.6));
  EXPECT_FALSE(shake.acts(5.2));
}

}  // namespace
}  // namespace firn
