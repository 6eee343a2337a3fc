// Bodies that turn freely in a mechanism, against closed forms, against other integrations of the
// equations of motion, and against the same bodies on joints.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "validation/verification/fixtures/mechanisms.h"

namespace firn {
namespace {

// A body that may go anywhere: three slides and a free rotation, with its origin at its center of
// mass. `inertia`: kg m^2 about it. Returns the frame.
int add_loose_body(Model& model, const std::string& name, double mass, const Vec3& center,
                   const Mat3& inertia) {
  const int frame = scenes::add_mover(
      model, name, mass, center, Vec3::Zero(),
      {scenes::slider(Vec3::UnitX()), scenes::slider(Vec3::UnitY()), scenes::slider(Vec3::UnitZ())},
      center);
  FreeBody& body = *model.frames[index(frame)].free;
  body.inertia = inertia;
  body.free_rotation = true;
  return frame;
}

// A loose body that a ball holds at the origin of the world.
struct HungBody {
  double mass = 0.3;                                         // kg
  Vec3 center = Vec3(0.05, 0.02, -0.06);                     // m
  Mat3 inertia = Mat3(Vec3(4e-4, 7e-4, 9e-4).asDiagonal());  // kg m^2, about the center
  Vec3 angular_velocity = Vec3(3, -4, 8);                    // rad/s, at the start
};

Solver start_hung_body(const HungBody& hung, double timestep, Coupling ball = {}) {
  Model model = scenes::mechanism();
  ball.name = "ball";
  ball.b = add_loose_body(model, "body", hung.mass, hung.center, hung.inertia);
  model.couplings = {ball};
  model.timestep = timestep;
  Solver solver(std::move(model));
  FrameStart go;
  const Vec3 velocity = hung.angular_velocity.cross(hung.center);
  go.coordinates = {0, 0, 0};
  go.rates = {velocity.x(), velocity.y(), velocity.z()};
  go.relative_angular_velocity = hung.angular_velocity;
  solver.start_frame(go);
  return solver;
}

// Orientation after `duration` s by Euler's equations about the fixed point.
Quat orientation_by_euler(const HungBody& hung, double duration) {
  const Mat3 about_pivot =
      hung.inertia + hung.mass * (hung.center.squaredNorm() * Mat3::Identity() -
                                  hung.center * hung.center.transpose());
  const Mat3 mobility = about_pivot.inverse();
  const auto orientation = [](const std::vector<double>& y) {
    return Quat(y[0], y[1], y[2], y[3]).normalized();
  };
  const auto rates = [&](const std::vector<double>& y) {  // of the body, in its axes
    const Quat q = orientation(y);
    const Vec3 w(y[4], y[5], y[6]);
    const Vec3 weight = q.conjugate() * Vec3(0, 0, -hung.mass * scenes::kGravity);
    const Vec3 torque = hung.center.cross(weight) - w.cross(about_pivot * w);
    const Vec3 faster = mobility * torque;
    const Quat turn = q * Quat(0, w.x(), w.y(), w.z());
    return std::vector<double>{0.5 * turn.w(), 0.5 * turn.x(), 0.5 * turn.y(), 0.5 * turn.z(),
                               faster.x(),     faster.y(),     faster.z()};
  };
  const Vec3& w = hung.angular_velocity;
  return orientation(scenes::runge_kutta({1, 0, 0, 0, w.x(), w.y(), w.z()}, duration, 5000, rates));
}

TEST(FreeRotationInMechanism, BodyOnABallTurnsAsEulersEquationsOfSecondOrderInTheStep) {
  constexpr double kDuration = 0.3;  // s
  const HungBody hung;
  const Quat exact = orientation_by_euler(hung, kDuration);
  std::vector<double> errors;
  for (const double timestep : {1e-3, 5e-4, 2.5e-4}) {
    Solver solver = start_hung_body(hung, timestep);
    scenes::run(solver, kDuration);
    const FrameState body = solver.frames()[0];
    errors.push_back(body.orientation.angularDistance(exact));
    EXPECT_LT((body.position - body.orientation * hung.center).norm(), 1e-12);
  }
  EXPECT_LT(errors[2], 1e-5);
  EXPECT_NEAR(errors[0] / errors[1], 4, 0.4);
  EXPECT_NEAR(errors[1] / errors[2], 4, 0.4);
}

// A symmetric top precesses steadily at W where A cos(tilt) W^2 - C n W + m g l = 0, with the
// moments of inertia A across the axis and C about it, and the spin n about it.
TEST(FreeRotationInMechanism, LagrangesTopPrecessesAtItsClosedForm) {
  constexpr double kArm = 0.08, kAlong = 5e-4, kAcross = 4e-4, kTilt = 0.5, kPrecession = 4;
  constexpr double kDuration = 0.5;  // s
  HungBody top;
  const double about_pivot = kAcross + top.mass * kArm * kArm;
  const double spin = (about_pivot * std::cos(kTilt) * kPrecession * kPrecession +
                       top.mass * scenes::kGravity * kArm) /
                      (kAlong * kPrecession);
  const Vec3 axis(std::sin(kTilt), 0, std::cos(kTilt));
  top.center = kArm * axis;
  top.inertia = kAcross * Mat3::Identity() + (kAlong - kAcross) * axis * axis.transpose();
  top.angular_velocity =
      kPrecession * Vec3::UnitZ() + (spin - kPrecession * std::cos(kTilt)) * axis;
  std::vector<double> errors;
  for (const double timestep : {2e-4, 1e-4}) {
    Solver solver = start_hung_body(top, timestep);
    scenes::run(solver, kDuration);
    const Vec3 now = solver.frames()[0].orientation * axis;
    EXPECT_NEAR(std::acos(now.z()), kTilt, 1e-5);
    errors.push_back(std::abs(std::atan2(now.y(), now.x()) - kPrecession * kDuration));
  }
  EXPECT_LT(errors[1], 5e-5);
  EXPECT_NEAR(errors[0] / errors[1], 4, 0.4);
}

TEST(FreeRotationInMechanism, BallBearsTheLoadOfTheJointOfASingleBody) {
  const HungBody hung;
  constexpr double kTimestep = 1e-4;
  Solver coupled = start_hung_body(hung, kTimestep);
  Model model = scenes::mechanism();
  scenes::add_mover(model, "body", hung.mass, hung.center, hung.inertia.diagonal(), {});
  model.frames[0].free->free_rotation = true;
  model.timestep = kTimestep;
  Solver single(std::move(model));
  FrameStart go;
  go.relative_angular_velocity = hung.angular_velocity;
  single.start_frame(go);
  for (Solver* solver : {&coupled, &single}) {
    scenes::run(*solver, 0.01);
    solver->clear_boundary_loads();
    scenes::run(*solver, 0.2);
  }
  const FrameState joint = single.frames()[0], loose = coupled.frames()[0];
  EXPECT_LT(joint.orientation.angularDistance(loose.orientation), 1e-5);
  EXPECT_GT(joint.reaction_impulse.norm(), 0.1);
  // They are sums over times that differ by half a step.
  EXPECT_LT((coupled.couplings()[0].impulse - joint.reaction_impulse).norm(), 1e-3);
  EXPECT_LT(loose.reaction_impulse.norm(), 1e-6);
}

// A bar on the end of a hinged one. Its ball joint allows more than the plane, where it stays.
TEST(FreeRotationInMechanism, PlaneChainMovesAsWithAHinge) {
  const auto end_of_chain = [](bool on_a_ball) {
    Model model = scenes::mechanism();
    const Vec3 middle(0.2, 0, 0);
    const int upper = scenes::add_bar(model, 0.3, Vec3::Zero(), middle, -1),
              lower = scenes::add_bar(model, 0.2, middle, Vec3(0.35, 0, 0), upper);
    if (on_a_ball) {
      FreeBody& body = *model.frames[index(lower)].free;
      body.joints.clear();
      body.free_rotation = true;
    }
    model.timestep = 1e-4;
    Solver solver(std::move(model));
    scenes::run(solver, 0.5);
    return solver.frames()[index(lower)];
  };
  const FrameState hinged = end_of_chain(false), loose = end_of_chain(true);
  EXPECT_GT(hinged.orientation.angularDistance(Quat::Identity()), 0.3);
  EXPECT_LT(hinged.orientation.angularDistance(loose.orientation), 1e-8);
  EXPECT_LT((hinged.position - loose.position).norm(), 1e-9);
  EXPECT_LT((hinged.reaction_impulse - loose.reaction_impulse).norm(), 1e-8);
}

// A crank about y, a rocker about z, and a rod on balls between their ends, which may spin about
// its own axis.
TEST(FreeRotationInMechanism, RodBetweenTwoBallsClosesASpatialLinkage) {
  constexpr double kCrank = 0.03, kRocker = 0.12;  // m
  const Vec3 pivot(0.2, 0.05, 0), end(kCrank, 0, 0), wrist = pivot + Vec3(0, kRocker, 0);
  const double length = (wrist - end).norm();
  Model model = scenes::mechanism();
  const int crank = scenes::add_bar(model, 0.1, Vec3::Zero(), end, -1),
            rocker =
                scenes::add_mover(model, "rocker", 0.2, 0.5 * (pivot + wrist),
                                  Vec3::Constant(2.4e-4), {scenes::hinge(Vec3::UnitZ())}, pivot),
            rod = add_loose_body(model, "rod", 0.2, 0.5 * (end + wrist), 1e-3 * Mat3::Identity());
  model.couplings = {scenes::pin(crank, rod, end), scenes::pin(rod, rocker, wrist)};
  scenes::drive_at(model, crank, 12);
  model.timestep = 1e-4;
  Solver solver(model);
  double worst_angle = 0, worst_end = 0;
  for (int k = 0; k < 6000; ++k) {
    solver.step();
    const std::vector<FrameState> frames = solver.frames();
    const double a = frames[index(crank)].joints[0].coordinate;
    const Vec3 from(kCrank * std::cos(a), 0, kCrank * std::sin(a)), apart = pivot - from;
    // |apart + kRocker (-sin b, cos b, 0)| is the length of the rod.
    const double along =
        (length * length - kRocker * kRocker - apart.squaredNorm()) / (2 * kRocker);
    const double b =
        std::acos(along / std::hypot(apart.x(), apart.y())) - std::atan2(apart.x(), apart.y());
    const FrameState& at = frames[index(rod)];
    const Vec3 tip = at.position + at.orientation * (end - model.frames[index(rod)].origin);
    worst_angle = std::max(worst_angle, std::abs(frames[index(rocker)].joints[0].coordinate - b));
    worst_end = std::max(worst_end, (tip - from).norm());
  }
  EXPECT_LT(worst_angle, 1e-11);
  EXPECT_LT(worst_end, 1e-12);
}

TEST(FreeRotationInMechanism, WeldTurnsALooseBodyWithTheOther) {
  Model model = scenes::mechanism();
  const Vec3 place(0.2, 0.01, 0.02);
  const int arm = scenes::add_bar(model, 0.4, Vec3::Zero(), Vec3(0.15, 0, 0), -1),
            tip = add_loose_body(model, "tip", 0.1, place, Vec3(1e-4, 2e-4, 2.5e-4).asDiagonal());
  Coupling weld = scenes::pin(arm, tip, Vec3(0.15, 0, 0));
  weld.kind = Coupling::Kind::weld;
  model.couplings = {weld};
  scenes::drive_at(model, arm, 9);
  model.timestep = 1e-4;
  Solver solver(std::move(model));
  for (int k = 0; k < 9000; ++k) {  // more than a turn
    solver.step();
    const std::vector<FrameState> frames = solver.frames();
    const FrameState &a = frames[index(arm)], &b = frames[index(tip)];
    ASSERT_LT(a.orientation.angularDistance(b.orientation), 1e-11);
    ASSERT_LT((a.orientation * place - b.position).norm(), 1e-11);
  }
}

TEST(FreeRotationInMechanism, HingeCouplingWithFrictionActsAsAHingeJoint) {
  const Vec3 center = 0.2 * Vec3(std::sin(0.5), 0, -std::cos(0.5));
  const Mat3 inertia = Vec3(2e-3, 1e-3, 3e-3).asDiagonal();
  Coupling pin;
  pin.name = "pin";
  pin.kind = Coupling::Kind::hinge;
  pin.direction = Vec3::UnitY();
  pin.friction_coefficient = 0.3;
  pin.bearing_radius = 5e-3;
  Joint axle = scenes::hinge(Vec3::UnitY());
  axle.friction_coefficient = pin.friction_coefficient;
  axle.bearing_radius = pin.bearing_radius;
  Model hinged = scenes::mechanism(), coupled = hinged;
  scenes::add_mover(hinged, "link", 0.3, center, inertia.diagonal(), {axle});
  pin.b = add_loose_body(coupled, "link", 0.3, center, inertia);
  coupled.couplings = {pin};
  hinged.timestep = coupled.timestep = 1e-4;
  Solver reference(std::move(hinged)), solver(std::move(coupled));
  scenes::run(reference, 1);
  scenes::run(solver, 1);
  const FrameState a = reference.frames()[0], b = solver.frames()[0];
  EXPECT_LT(a.orientation.angularDistance(b.orientation), 1e-4);
  const double heat = a.joints[0].dissipated_friction;
  EXPECT_GT(heat, 0);
  EXPECT_NEAR(solver.couplings()[0].dissipated_friction, heat, 1e-3 * heat);
}

// A flywheel on a pin, which bears its weight along the axis: its rate falls by mu r m g t / I.
TEST(FreeRotationInMechanism, FrictionOfAPinStopsASpinningBody) {
  constexpr double kInertia = 1e-3, kSpeed = 3;  // kg m^2, rad/s
  HungBody wheel;
  wheel.center = Vec3::Zero();
  wheel.inertia = kInertia * Mat3::Identity();
  wheel.angular_velocity = kSpeed * Vec3::UnitZ();
  Coupling pin;
  pin.direction = Vec3::UnitZ();
  pin.friction_coefficient = 0.2;
  pin.bearing_radius = 0.01;
  const double torque =
      pin.friction_coefficient * pin.bearing_radius * wheel.mass * scenes::kGravity;  // N m
  Solver solver = start_hung_body(wheel, 1e-4, pin);
  scenes::run(solver, 0.3);
  EXPECT_NEAR(solver.frames()[0].relative_angular_velocity.z(), kSpeed - torque * 0.3 / kInertia,
              1e-9);
  EXPECT_LT(std::abs(solver.energy().free_bodies.balance() - 0.5 * kInertia * kSpeed * kSpeed),
            1e-12);
  scenes::run(solver, 0.3);
  EXPECT_LT(solver.frames()[0].relative_angular_velocity.norm(), 1e-12);
  EXPECT_NEAR(solver.couplings()[0].dissipated_friction, 0.5 * kInertia * kSpeed * kSpeed, 1e-12);
}

// A damped arm that carries a body on a ball joint, which spins. Returns the largest change of the
// balance of energies over 0.5 s, J.
double energy_error_of_chain(double timestep) {
  Model model = scenes::mechanism();
  const int arm = scenes::add_bar(model, 0.3, Vec3::Zero(), Vec3(0.2, 0, 0), -1);
  model.frames[index(arm)].free->joints[0].damping = 5e-3;
  const int body = scenes::add_mover(model, "body", 0.2, Vec3(0.25, 0.03, -0.04),
                                     Vec3(3e-4, 5e-4, 6e-4), {}, Vec3(0.2, 0, 0));
  model.frames[index(body)].parent = arm;
  model.frames[index(body)].free->free_rotation = true;
  model.timestep = timestep;
  Solver solver(std::move(model));
  FrameStart go;
  go.frame = body;
  go.relative_angular_velocity = Vec3(4, -3, 10);
  solver.start_frame(go);
  const double start = solver.energy().free_bodies.balance();
  double worst = 0;
  for (long k = std::lround(0.5 / timestep); k > 0; --k) {
    solver.step();
    worst = std::max(worst, std::abs(solver.energy().free_bodies.balance() - start));
  }
  EXPECT_GT(solver.energy().free_bodies.dissipated_damping, 1e-3);
  return worst;
}

TEST(FreeRotationInMechanism, EnergyBalancesToSecondOrderInTheStep) {
  const double coarse = energy_error_of_chain(4e-4), fine = energy_error_of_chain(1e-4);
  EXPECT_LT(fine, 1e-5);
  EXPECT_GT(coarse, 8 * fine);  // 16 by the order
}

TEST(FreeRotationInMechanism, EnergyOfABodyOnABallDoesNotDrift) {
  Solver solver = start_hung_body({}, 5e-4);
  const double start = solver.energy().free_bodies.balance();
  double early = 0, late = 0;
  for (int k = 0; k < 20000; ++k) {
    solver.step();
    double& worst = k < 10000 ? early : late;
    worst = std::max(worst, std::abs(solver.energy().free_bodies.balance() - start));
  }
  EXPECT_LT(early, 1e-5);
  EXPECT_LT(late, 2 * early);
}

// A ball without friction at the axis of a turntable does not turn the body.
TEST(FreeRotationInMechanism, BodyOnABallDoesNotFeelItsGroundTurn) {
  const auto end_pose = [](double speed) {
    const HungBody hung;
    Model model = scenes::mechanism();
    MotionFrame table;
    table.name = "table";
    Motion& turn = table.motions.emplace_back();
    turn.kind = Motion::Kind::rotation;
    turn.axis = Vec3::UnitZ();
    turn.angular_speed = speed;
    model.frames.push_back(table);
    const int body = add_loose_body(model, "body", hung.mass, hung.center, hung.inertia);
    model.frames[index(body)].parent = 0;
    model.couplings = {scenes::pin(0, body, Vec3::Zero())};
    model.timestep = 5e-5;
    Solver solver(std::move(model));
    scenes::run(solver, 0.4);
    return solver.frames()[index(body)];
  };
  const FrameState still = end_pose(0), turned = end_pose(6);
  EXPECT_GT(still.orientation.angularDistance(Quat::Identity()), 0.3);
  EXPECT_LT(still.orientation.angularDistance(turned.orientation), 1e-4);
  EXPECT_LT((still.position - turned.position).norm(), 1e-5);
}

TEST(FreeRotationInMechanism, StartsFromThePoseOfAnEarlierRun) {
  Solver earlier = start_hung_body({}, 1e-4), later = start_hung_body({}, 1e-4);
  scenes::run(earlier, 0.2);
  const FrameState at = earlier.frames()[0];
  FrameStart go;
  go.orientation = at.orientation;
  go.relative_angular_velocity = at.relative_angular_velocity;
  for (const FrameState::JointState& joint : at.joints) {
    go.coordinates.push_back(joint.coordinate);
    go.rates.push_back(joint.rate);
  }
  later.start_frame(go);
  scenes::run(earlier, 0.1);
  scenes::run(later, 0.1);
  const FrameState a = earlier.frames()[0], b = later.frames()[0];
  EXPECT_GT(a.orientation.angularDistance(at.orientation), 0.1);
  EXPECT_LT(a.orientation.angularDistance(b.orientation), 1e-10);
  EXPECT_LT((a.position - b.position).norm(), 1e-10);
}

TEST(FreeRotationInMechanism, ResumesBitForBit) {
  Coupling ball;
  ball.direction = Vec3(0, 0.6, 0.8);
  ball.friction_coefficient = 0.1;
  ball.bearing_radius = 4e-3;
  for (const int saved : {0, 1, 2, 300}) {
    Solver whole = start_hung_body({}, 1e-4, ball), first = start_hung_body({}, 1e-4, ball),
           second = start_hung_body({}, 1e-4, ball);
    for (int k = 0; k < 700; ++k) whole.step();
    for (int k = 0; k < saved; ++k) first.step();
    second.restore(first.save());
    for (int k = saved; k < 700; ++k) second.step();
    EXPECT_EQ(whole.save(), second.save()) << saved;
    EXPECT_GT(whole.couplings()[0].dissipated_friction, 0);
  }
}

}  // namespace
}  // namespace firn
