// Friction in the pins and slots of couplings. Closed forms: validation/verification,
// machine.pin_friction.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <utility>

#include "tests/support/error_of.h"
#include "validation/verification/fixtures/mechanisms.h"

namespace firn {
namespace {

using testing::HasSubstr;

// A link that turns about a pin at the origin, drawn at an angle from straight down.
struct Link {
  double mass = 0.3, arm = 0.2, own_inertia = 1e-3, angle = 0.5;  // kg, m, kg m^2, rad

  Vec3 center() const { return arm * Vec3(std::sin(angle), 0, -std::cos(angle)); }
};

int add_link(Model& model, const Link& link, std::vector<Joint> joints) {
  return scenes::add_mover(model, "link", link.mass, link.center(),
                           Vec3::Constant(link.own_inertia), std::move(joints));
}

// Its joints let it go anywhere in the plane; a coupling holds it. The turn is its last joint.
Model link_on_a_coupling(const Link& link, const Coupling& friction) {
  Model model = scenes::mechanism();
  add_link(model, link,
           {scenes::slider(Vec3::UnitX()), scenes::slider(Vec3::UnitZ()),
            scenes::hinge(-Vec3::UnitY())});
  Coupling at = friction;
  at.name = "pin";
  at.b = 0;
  at.direction = Vec3::UnitY();
  model.couplings = {at};
  model.timestep = 1e-4;
  return model;
}

FrameState::JointState turn_of(const Solver& solver) { return solver.frames()[0].joints.back(); }

TEST(CouplingFriction, OfAPinActsAsThatOfTheBearingOfAHinge) {
  std::mt19937 random(11);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution(low, high)(random);
  };
  for (const Coupling::Kind kind :
       {Coupling::Kind::ball, Coupling::Kind::hinge, Coupling::Kind::ball}) {
    const Link link{between(0.1, 0.5), between(0.1, 0.3), between(1e-4, 2e-3), between(0.3, 1.2)};
    Coupling pin;
    pin.kind = kind;
    pin.friction = between(0, 1e-3);
    pin.friction_coefficient = between(0.1, 0.4);
    pin.bearing_radius = between(2e-3, 8e-3);
    Joint axle = scenes::hinge(-Vec3::UnitY());
    axle.friction = pin.friction;
    axle.friction_coefficient = pin.friction_coefficient;
    axle.bearing_radius = pin.bearing_radius;
    Model hinged = scenes::mechanism();
    add_link(hinged, link, {axle});
    hinged.timestep = 1e-4;
    Solver coupled(link_on_a_coupling(link, pin)), reference(hinged);
    scenes::run(coupled, 1);
    scenes::run(reference, 1);
    const FrameState::JointState a = turn_of(coupled), b = turn_of(reference);
    // They differ in the load of the first step, before which neither is known.
    EXPECT_NEAR(a.coordinate, b.coordinate, 1e-4);
    EXPECT_NEAR(a.rate, b.rate, 1e-3);
    const double heat = b.dissipated_friction;
    EXPECT_GT(heat, 0);
    EXPECT_NEAR(coupled.couplings()[0].dissipated_friction, heat, 1e-3 * heat);
    EXPECT_EQ(a.dissipated_friction, 0);
  }
}

TEST(CouplingFriction, DoesNotDependOnWhichBodyIsNamedFirst) {
  const Link link;
  for (const Coupling::Kind kind : {Coupling::Kind::ball, Coupling::Kind::hinge}) {
    Coupling pin;
    pin.kind = kind;
    pin.friction_coefficient = 0.3;
    pin.bearing_radius = 5e-3;
    Model model = link_on_a_coupling(link, pin), turned = model;
    std::swap(turned.couplings[0].a, turned.couplings[0].b);
    Solver one(model), other(turned);
    scenes::run(one, 1);
    scenes::run(other, 1);
    EXPECT_NEAR(turn_of(one).coordinate, turn_of(other).coordinate, 1e-4);
    const double heat = one.couplings()[0].dissipated_friction;
    EXPECT_GT(heat, 0);
    EXPECT_NEAR(other.couplings()[0].dissipated_friction, heat, 1e-3 * heat);
  }
}

// A prescribed frame below both turns, so that the rate of the pin is not that of the link.
TEST(CouplingFriction, IsThatOfABearingOnATurningFrameToo) {
  const Link link;
  Joint axle = scenes::hinge(-Vec3::UnitY());
  axle.friction_coefficient = 0.3;
  axle.bearing_radius = 5e-3;
  Coupling pin;
  pin.name = "pin";
  pin.kind = Coupling::Kind::hinge;
  pin.direction = Vec3::UnitY();
  pin.a = 0;
  pin.b = 1;
  pin.friction_coefficient = axle.friction_coefficient;
  pin.bearing_radius = axle.bearing_radius;
  const auto on_turning_frame = [&](std::vector<Joint> joints) {
    Model model = scenes::mechanism();
    MotionFrame frame;
    frame.name = "frame";
    Motion turn;
    turn.kind = Motion::Kind::rotation;
    turn.axis = Vec3::UnitY();
    turn.angular_speed = 3;
    frame.motions = {turn};
    model.frames.push_back(frame);
    model.frames[static_cast<std::size_t>(add_link(model, link, std::move(joints)))].parent = 0;
    model.timestep = 1e-4;
    return model;
  };
  Model coupled = on_turning_frame({scenes::slider(Vec3::UnitX()), scenes::slider(Vec3::UnitZ()),
                                    scenes::hinge(-Vec3::UnitY())});
  coupled.couplings = {pin};
  Solver with_pin(coupled), reference(on_turning_frame({axle}));
  scenes::run(with_pin, 1);
  scenes::run(reference, 1);
  const FrameState::JointState a = with_pin.frames()[1].joints.back(),
                               b = reference.frames()[1].joints.back();
  EXPECT_GT(std::abs(b.coordinate), 0.5);
  EXPECT_NEAR(a.coordinate, b.coordinate, 1e-3);
  EXPECT_NEAR(with_pin.couplings()[0].dissipated_friction, b.dissipated_friction,
              5e-3 * b.dissipated_friction);
}

// The joints of the link bear nothing: neither its weight nor the friction of the pin.
TEST(CouplingFriction, IsPartOfTheLoadOfTheCoupling) {
  Coupling pin;
  pin.friction_coefficient = 0.3;
  pin.bearing_radius = 0.01;
  Solver solver(link_on_a_coupling({}, pin));
  scenes::run(solver, 0.01);
  solver.clear_boundary_loads();
  scenes::run(solver, 0.1);
  const CouplingState coupling = solver.couplings()[0];
  const FrameState link = solver.frames()[0];
  // The link falls back to straight down, against which the friction acts.
  const double least =
      0.1 * pin.friction_coefficient * pin.bearing_radius * 0.8 * 0.3 * scenes::kGravity;  // N m s
  EXPECT_GT(std::abs(coupling.angular_impulse.y()), least);
  EXPECT_LT(link.reaction_angular_impulse.norm(), 1e-2 * least);
  EXPECT_LT(link.reaction_impulse.norm(), 1e-4 * coupling.impulse.norm());
}

TEST(CouplingFriction, HoldsUpToItsLimitAndNotBeyond) {
  const Link level{.angle = std::numbers::pi / 2};
  const double needed = level.mass * scenes::kGravity * level.arm;  // N m
  for (const double part : {0.999, 1.001}) {
    Coupling pin;
    pin.friction = part * needed;
    Solver solver(link_on_a_coupling(level, pin));
    scenes::run(solver, 0.2);
    if (part > 1) {
      EXPECT_LT(std::abs(turn_of(solver).coordinate), 1e-12);
      EXPECT_LT(std::abs(turn_of(solver).rate), 1e-12);
      EXPECT_LT(std::abs(solver.couplings()[0].dissipated_friction), 1e-15);
    } else {
      EXPECT_LT(turn_of(solver).coordinate, -5e-4);
    }
  }
}

TEST(CouplingFriction, OfASlotIsThatOfAnInclinedPlane) {
  for (const auto& [slope, friction] : {std::pair{0.5, 0.2}, {0.5, 0.4}, {0.2, 0.3}}) {
    Model model = scenes::mechanism();
    const Vec3 down(std::cos(slope), 0, -std::sin(slope));
    constexpr double kMass = 0.2;
    scenes::add_mover(model, "bead", kMass, Vec3::Zero(), Vec3::Constant(1e-5),
                      {scenes::slider(Vec3::UnitX()), scenes::slider(Vec3::UnitZ())});
    Coupling slot = scenes::pin(-1, 0, Vec3::Zero());
    slot.kind = Coupling::Kind::slot;
    slot.direction = down;
    slot.friction_coefficient = friction;
    model.couplings = {slot};
    model.timestep = 1e-4;
    Solver solver(model);
    scenes::run(solver, 0.3);
    const double way = solver.frames()[0].position.dot(down),
                 pressed = kMass * scenes::kGravity * std::cos(slope);
    const double a = scenes::kGravity * (std::sin(slope) - friction * std::cos(slope));
    const double expected = a > 0 ? 0.5 * a * 0.3 * 0.3 : 0;
    EXPECT_NEAR(way, expected, 1e-12 + 1e-6 * expected);
    EXPECT_NEAR(solver.couplings()[0].dissipated_friction, friction * pressed * way,
                1e-15 + 1e-6 * way);
  }
}

// A slider-crank with friction in all of its joints and in the coupling.
Model linkage_with_friction() {
  Model model = scenes::mechanism();
  const Vec3 end(0.04, 0, 0), wrist(0.19, 0, 0.01);
  const int crank = scenes::add_bar(model, 0.1, Vec3::Zero(), end, -1),
            rod = scenes::add_bar(model, 0.2, end, wrist, crank),
            piston = scenes::add_mover(model, "piston", 0.3, wrist, Vec3::Constant(1e-4),
                                       {scenes::slider(Vec3::UnitX())}, wrist);
  for (MotionFrame& frame : model.frames) {
    Joint& joint = frame.free->joints[0];
    joint.friction_coefficient = 0.1;
    joint.bearing_radius = joint.kind == Joint::Kind::rotation ? 4e-3 : 0;
  }
  Coupling pin = scenes::pin(rod, piston, wrist);
  pin.direction = Vec3::UnitY();
  pin.friction_coefficient = 0.2;
  pin.bearing_radius = 4e-3;
  model.couplings = {pin};
  scenes::drive_at(model, crank, 20, 1);
  model.timestep = 1e-4;
  return model;
}

TEST(CouplingFriction, ResumesBitForBit) {
  const Model model = linkage_with_friction();
  for (const int saved : {0, 1, 2, 300}) {
    Solver whole(model), first(model), second(model);
    for (int k = 0; k < 700; ++k) whole.step();
    for (int k = 0; k < saved; ++k) first.step();
    second.restore(first.save());
    for (int k = saved; k < 700; ++k) second.step();
    EXPECT_EQ(whole.save(), second.save()) << saved;
    EXPECT_GT(whole.couplings()[0].dissipated_friction, 0);
  }
}

TEST(CouplingFriction, IsRefusedWhereNothingTurnsOrSlides) {
  const auto message = [](Coupling::Kind kind, double coefficient, double radius) {
    Model model = linkage_with_friction();
    model.couplings[0].kind = kind;
    model.couplings[0].direction = Vec3::UnitZ();
    model.couplings[0].friction_coefficient = coefficient;
    model.couplings[0].bearing_radius = radius;
    return test::error_if_any([&] { validate(model); });
  };
  using Kind = Coupling::Kind;
  EXPECT_EQ(message(Kind::slot, 0.1, 0), "");
  EXPECT_THAT(message(Kind::weld, 0.1, 1e-3), HasSubstr("friction without a pin or slot"));
  EXPECT_THAT(message(Kind::gear, 0.1, 1e-3), HasSubstr("friction without a pin or slot"));
  EXPECT_THAT(message(Kind::ball, 0.1, 0), HasSubstr("without a bearing radius"));
  EXPECT_THAT(message(Kind::ball, -0.1, 1e-3), HasSubstr("negative friction"));
}

}  // namespace
}  // namespace firn
