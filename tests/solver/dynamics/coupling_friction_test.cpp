// Friction in the pins and slots of couplings. Closed forms: validation/verification,
// machine.pin_friction.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

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

// The link on pins of these kinds, all on one axis.
Model link_on_pins(const Link& link, const Coupling& friction,
                   const std::vector<Coupling::Kind>& kinds) {
  Model model = link_on_a_coupling(link, friction);
  const Coupling pin = model.couplings[0];
  model.couplings.clear();
  for (const Coupling::Kind kind : kinds) {
    const std::size_t number = model.couplings.size();
    Coupling& next = model.couplings.emplace_back(pin);
    next.kind = kind;
    next.name = fmt::format("pin {}", number);
    next.position = {0, 0.05 * static_cast<double>(number) - 0.02, 0};
  }
  return model;
}

double heat_of_pins(const Solver& solver) {
  double sum = 0;
  for (const CouplingState& pin : solver.couplings()) sum += pin.dissipated_friction;
  return sum;
}

TEST(CouplingFriction, OfPinsOnOneAxisIsThatOfASinglePin) {
  using Kind = Coupling::Kind;
  Coupling friction;
  friction.friction_coefficient = 0.3;
  friction.bearing_radius = 5e-3;
  Solver single(link_on_pins({}, friction, {Kind::hinge}));
  scenes::run(single, 1);
  const double heat = heat_of_pins(single);
  EXPECT_GT(heat, 1e-3);
  const FrameState::JointState reference = turn_of(single);
  single.clear_boundary_loads();
  scenes::run(single, 0.1);
  const Vec3 load = single.couplings()[0].impulse;
  const std::vector<std::vector<Kind>> all = {{Kind::hinge, Kind::hinge},
                                              {Kind::ball, Kind::ball},
                                              {Kind::ball, Kind::ball, Kind::ball},
                                              {Kind::ball, Kind::hinge}};
  for (const std::vector<Kind>& kinds : all) {
    Solver shared(link_on_pins({}, friction, kinds));
    scenes::run(shared, 1);
    EXPECT_NEAR(turn_of(shared).coordinate, reference.coordinate, 1e-9);
    EXPECT_NEAR(turn_of(shared).rate, reference.rate, 1e-8);
    EXPECT_NEAR(heat_of_pins(shared), heat, 1e-8 * heat);
    EXPECT_EQ(shared.diagnostics().unconverged_steps, 0u);
    const std::vector<CouplingState> after = shared.couplings();
    shared.clear_boundary_loads();
    scenes::run(shared, 0.1);
    const std::vector<CouplingState> pins = shared.couplings();
    Vec3 sum = Vec3::Zero();
    for (const CouplingState& pin : pins) sum += pin.impulse;
    EXPECT_LT((sum - load).norm(), 1e-8 * load.norm());
    if (kinds.front() != kinds.back()) continue;
    // Pins of one kind share load and heat equally, but for the heat of the steps at rest.
    const auto count = static_cast<double>(kinds.size());
    for (std::size_t k = 0; k < pins.size(); ++k) {
      EXPECT_LT((count * pins[k].impulse - load).norm(), 1e-8 * load.norm());
      EXPECT_NEAR(count * after[k].dissipated_friction, heat, 1e-3 * heat);
    }
  }
}

TEST(CouplingFriction, OfUnequalPinsOnOneAxisIsThatOfTheirMean) {
  using Kind = Coupling::Kind;
  Coupling friction;
  friction.friction_coefficient = 0.2;
  friction.bearing_radius = 5e-3;
  Solver single(link_on_pins({}, friction, {Kind::hinge}));
  Model model = link_on_pins({}, friction, {Kind::hinge, Kind::hinge});
  model.couplings[0].friction_coefficient = 0.1;
  model.couplings[1].friction_coefficient = 0.3;
  Solver shared(model);
  scenes::run(single, 1);
  scenes::run(shared, 1);
  EXPECT_NEAR(turn_of(shared).coordinate, turn_of(single).coordinate, 1e-9);
  const double heat = heat_of_pins(single);
  EXPECT_NEAR(heat_of_pins(shared), heat, 1e-8 * heat);
  EXPECT_NEAR(shared.couplings()[0].dissipated_friction, 0.25 * heat, 1e-3 * heat);
}

TEST(CouplingFriction, OfPinsOnOneAxisHoldsUpToTheSumOfTheirLimits) {
  using Kind = Coupling::Kind;
  const Link level{.angle = std::numbers::pi / 2};
  const double needed = level.mass * scenes::kGravity * level.arm;  // N m
  for (const double part : {0.999, 1.001}) {
    Coupling friction;
    friction.friction = 0.5 * part * needed;
    Solver solver(link_on_pins(level, friction, {Kind::hinge, Kind::hinge}));
    scenes::run(solver, 0.2);
    if (part > 1) {
      EXPECT_LT(std::abs(turn_of(solver).coordinate), 1e-12);
      EXPECT_LT(std::abs(heat_of_pins(solver)), 1e-15);
    } else {
      EXPECT_LT(turn_of(solver).coordinate, -5e-4);
    }
  }
}

// The joint bears all, whatever the direction of its axis.
TEST(CouplingFriction, OfAPinOnTheAxisOfAJointHasNoLoad) {
  for (const Vec3& axis : {Vec3(Vec3::UnitY()), Vec3(0.6, 0.64, 0.48)}) {
    Joint hinge = scenes::hinge(axis);
    hinge.friction_coefficient = 0.2;
    hinge.bearing_radius = 5e-3;
    Model model = scenes::mechanism();
    scenes::add_mover(model, "link", 0.3, {0.2, 0, -0.1}, Vec3::Constant(1e-3), {hinge});
    model.timestep = 1e-4;
    Model pinned = model;
    Coupling pin = scenes::pin(-1, 0, 0.2 * axis);
    pin.kind = Coupling::Kind::hinge;
    pin.direction = axis;
    pin.friction_coefficient = 0.4;
    pin.bearing_radius = 5e-3;
    pinned.couplings = {pin};
    Solver alone(model), with_pin(pinned);
    scenes::run(alone, 0.4);
    scenes::run(with_pin, 0.4);
    EXPECT_GT(std::abs(turn_of(alone).coordinate), 0.1);
    EXPECT_NEAR(turn_of(with_pin).coordinate, turn_of(alone).coordinate, 1e-5);
    const double heat = turn_of(alone).dissipated_friction;
    EXPECT_GT(heat, 0);
    EXPECT_NEAR(turn_of(with_pin).dissipated_friction, heat, 1e-3 * heat);
    EXPECT_LT(with_pin.couplings()[0].impulse.norm(), 1e-12);
    EXPECT_EQ(with_pin.couplings()[0].dissipated_friction, 0);
  }
}

const Vec3 kPinOfThree(0.2, 0, 0);  // m

// A bar on a hinge, and two more on one pin at its end: on joints of the first bar, or loose in the
// plane with a coupling to it each. The turn of a bar is its last joint.
Model three_bars(bool by_couplings, double friction) {
  Model model = scenes::mechanism();
  const int first = scenes::add_bar(model, 0.3, Vec3::Zero(), kPinOfThree, -1);
  for (const Vec3& tip : {Vec3(0.2, 0, -0.15), Vec3(0.3, 0, 0.1)}) {
    const int bar = scenes::add_bar(model, 0.2, kPinOfThree, tip, by_couplings ? -1 : first);
    std::vector<Joint>& joints = model.frames[index(bar)].free->joints;
    if (by_couplings) {
      Coupling pin = scenes::pin(first, bar, kPinOfThree);
      pin.direction = Vec3::UnitY();
      pin.friction_coefficient = friction;
      pin.bearing_radius = 5e-3;
      model.couplings.push_back(pin);
      joints = {scenes::slider(Vec3::UnitX()), scenes::slider(Vec3::UnitZ()), joints[0]};
    } else {
      joints[0].friction_coefficient = friction;
      joints[0].bearing_radius = 5e-3;
    }
  }
  model.timestep = 1e-4;
  return model;
}
// A third coupling between the last two bars: one more than the pin needs.
Model three_bars_with_a_third_pin(double friction) {
  Model model = three_bars(true, friction);
  Coupling pin = model.couplings[0];
  pin.name = "third";
  pin.a = 1;
  pin.b = 2;
  model.couplings.push_back(pin);
  return model;
}

TEST(CouplingFriction, OfThreeBarsOnOnePinIsThatOfTheirJoints) {
  Solver coupled(three_bars(true, 0.3)), jointed(three_bars(false, 0.3));
  scenes::run(coupled, 0.4);
  scenes::run(jointed, 0.4);
  const std::vector<FrameState> a = coupled.frames(), b = jointed.frames();
  EXPECT_GT(std::abs(b[0].joints[0].coordinate), 0.3);
  EXPECT_NEAR(a[0].joints[0].coordinate, b[0].joints[0].coordinate, 1e-3);
  for (const std::size_t bar : {1u, 2u}) {
    EXPECT_NEAR(a[bar].joints.back().coordinate,
                b[0].joints[0].coordinate + b[bar].joints[0].coordinate, 1e-3);
    const double heat = b[bar].joints[0].dissipated_friction;
    EXPECT_GT(heat, 1e-4);
    EXPECT_NEAR(coupled.couplings()[bar - 1].dissipated_friction, heat, 0.01 * heat);
  }
  EXPECT_EQ(coupled.diagnostics().unconverged_steps, 0u);
}

TEST(CouplingFriction, AThirdPinOfThreeBarsChangesNoMotionWithoutIt) {
  Solver two(three_bars(true, 0)), three(three_bars_with_a_third_pin(0));
  for (Solver* solver : {&two, &three}) {
    scenes::run(*solver, 0.3);
    solver->clear_boundary_loads();
    scenes::run(*solver, 0.1);
  }
  for (std::size_t bar = 0; bar < 3; ++bar)
    EXPECT_NEAR(three.frames()[bar].joints.back().coordinate,
                two.frames()[bar].joints.back().coordinate, 1e-9);
  // Each bar bears the same in all.
  const std::vector<CouplingState> a = two.couplings(), b = three.couplings();
  const double load = a[0].impulse.norm();
  EXPECT_GT(b[2].impulse.norm(), 0.01 * load);
  EXPECT_LT((b[0].impulse - b[2].impulse - a[0].impulse).norm(), 1e-7 * load);
  EXPECT_LT((b[1].impulse + b[2].impulse - a[1].impulse).norm(), 1e-7 * load);
}

// Which share of the load each of the three pins bears is not determined; the friction of each
// follows its own share.
TEST(CouplingFriction, OfThreePinsOfThreeBarsFollowsTheirShares) {
  const Model model = three_bars_with_a_third_pin(0.3);
  Solver solver(model);
  const auto rate_of_pin = [&](std::size_t c) {
    const std::vector<FrameState> frames = solver.frames();
    return frames[index(model.couplings[c].b)].joints.back().rate -
           frames[index(model.couplings[c].a)].joints.back().rate;
  };
  const double start = solver.energy().free_bodies.balance();
  double expected[3] = {};
  for (int k = 0; k < 4000; ++k) {
    double before[3];
    for (std::size_t c = 0; c < 3; ++c) before[c] = rate_of_pin(c);
    solver.clear_boundary_loads();
    solver.step();
    const std::vector<CouplingState> pins = solver.couplings();
    for (std::size_t c = 0; c < 3; ++c)
      expected[c] +=
          0.3 * 5e-3 * pins[c].impulse.norm() * std::abs(0.5 * (before[c] + rate_of_pin(c)));
  }
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_GT(expected[c], 1e-5);
    EXPECT_NEAR(solver.couplings()[c].dissipated_friction, expected[c], 0.02 * expected[c]);
  }
  EXPECT_NEAR(solver.energy().free_bodies.balance(), start, 1e-2 * heat_of_pins(solver));
  EXPECT_EQ(solver.diagnostics().unconverged_steps, 0u);
}

// A motor turns the link slowly against a pin with much friction.
Model link_driven_against_its_pin(double friction) {
  Coupling pin;
  pin.friction = friction;
  Model model = link_on_a_coupling({}, pin);
  Motor motor;
  motor.speed = 1e-3;
  model.frames[0].free->joints.back().motors = {motor};
  return model;
}

TEST(CouplingFriction, ConvergesHoweverSlowlyAMotorTurnsAgainstIt) {
  for (const double friction : {10.0, 1e3, 1e5}) {
    Solver solver(link_driven_against_its_pin(friction));
    scenes::run(solver, 0.01);
    EXPECT_EQ(solver.diagnostics().unconverged_steps, 0u) << friction;
    EXPECT_NEAR(turn_of(solver).motor_impulse / 0.01, friction, 0.5);  // and what gravity takes
  }
}

TEST(CouplingFriction, CountsTheStepsInWhichItDoesNotConverge) {
  const Model stiff = link_driven_against_its_pin(kUnbounded);
  Solver unconverged(stiff);
  scenes::run(unconverged, 0.01);
  EXPECT_EQ(unconverged.diagnostics().unconverged_steps, unconverged.steps());
  Model on_threads = stiff;
  on_threads.numerics.threads = 3;
  Solver threaded(on_threads), resumed(stiff);
  scenes::run(threaded, 0.01);
  EXPECT_EQ(threaded.hash(), unconverged.hash());
  resumed.restore(unconverged.save());
  resumed.step();
  EXPECT_EQ(resumed.diagnostics().unconverged_steps, unconverged.steps() + 1);
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
