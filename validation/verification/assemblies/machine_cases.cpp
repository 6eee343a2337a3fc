// Parts of machines in contact with each other, and the joints that carry them.
#include <fmt/format.h>

#include <cmath>

#include "validation/verification/assemblies/cases.h"
#include "validation/verification/fixtures/closed_forms.h"
#include "validation/verification/fixtures/mechanisms.h"

namespace firn::verification {

std::vector<VerificationCase> drive_cases();             // drive_cases.cpp
std::vector<VerificationCase> linkage_cases();           // linkage_cases.cpp
std::vector<VerificationCase> linkage_friction_cases();  // linkage_friction_cases.cpp

namespace {

using namespace scenes;

// A hammer on a hinge strikes a wall without gravity.
std::vector<Check> hammer() {
  constexpr double kArm = 0.3, kRadius = 0.02, kMass = 0.4, kOwn = 2e-3, kStiffness = 1e5;
  constexpr double kInertia = kOwn + kMass * 0.04;  // about the hinge, 0.2 m from the center
  LargestError rebound("rate after over before", 0.01), peak("largest force", 0.005);
  LargestError loss("energy lost", 0.01);
  for (const double e : {1.0, 0.8, 0.5, 0.2}) {
    for (const double speed : {0.1, 1.0}) {  // m/s, of the head
      Model model = mechanism();
      model.gravity.setZero();
      const int frame = add_mover(model, "hammer", kMass, {0, 0, -0.2}, Vec3(kOwn, kOwn, kOwn),
                                  {hinge(Vec3::UnitY())});
      const int head = add_ball(model, "head", {0, 0, -kArm}, kRadius, frame);
      const int wall = add_plane(model, {-kRadius, 0, 0}, Vec3::UnitX());
      add_contact(model, head, wall, 0, e, kStiffness);
      const double mass = kInertia / (kArm * kArm);
      model.timestep = quarter_period(mass, kStiffness / (e * e)) / 200;
      Solver solver(model);
      const double rate = speed / kArm, away = 0.02;  // rad before the wall
      start_mover(solver, frame, {-away}, {rate});
      run(solver, away / rate + 10 * quarter_period(mass, kStiffness));
      const BoundaryContactState contact = solver.boundary_contacts()[0];
      const double after = solver.frames()[0].joints[0].rate, ideal = restitution_with_floor(e);
      const std::string where = fmt::format("e = {}, {} m/s", e, speed);
      rebound.add(-after / rate, ideal, where);
      peak.add(contact.peak_normal_force, speed * std::sqrt(mass * kStiffness), where);
      const double before = 0.5 * kInertia * rate * rate;
      loss.add(
          1 + (contact.dissipated_normal - 0.5 * kInertia * (rate * rate - after * after)) / before,
          1, where);
    }
  }
  return {rebound.check(), peak.check(), loss.check()};
}

// A box is put on a moving sled, which it brakes until both move alike.
std::vector<Check> sled() {
  constexpr double kSled = 3, kBox = 2, kSpeed = 1, kFriction = 0.3, kStiffness = 1e6;
  Model model = mechanism();
  const int sled =
      add_mover(model, "sled", kSled, {0, 0, -0.05}, Vec3::Constant(0.01), {slider(Vec3::UnitX())});
  const int box = add_mover(model, "box", kBox, {0, 0, 0.05}, Vec3::Constant(0.01),
                            {slider(Vec3::UnitX()), slider(Vec3::UnitZ())});
  const int bed = add_panel(model, "bed", {-1, -0.2, -0.1}, {1, 0.2, 0});
  const double dent = kBox * kGravity / kStiffness;
  const int load = add_panel(model, "load", {-0.05, -0.05, -dent}, {0.05, 0.05, 0.1 - dent});
  model.boundaries[bed].frame = sled;
  model.boundaries[load].frame = box;
  add_contact(model, load, bed, kFriction, 0.5, kStiffness);
  model.timestep = 2e-5;
  Solver solver(model);
  start_mover(solver, sled, {0}, {kSpeed});
  const double closing = kFriction * kGravity * (1 + kBox / kSled);
  run(solver, 2 * kSpeed / closing);
  // They ring against each other on the springs of their friction: means over 0.2 s.
  const auto before = solver.frames();
  const double start = solver.time();
  run(solver, 0.2);
  const auto frames = solver.frames();
  const auto mean_rate = [&](int f) {
    return (frames[f].joints[0].coordinate - before[f].joints[0].coordinate) /
           (solver.time() - start);
  };
  const double common = kSpeed * kSled / (kSled + kBox);
  const double slip = frames[0].joints[0].coordinate - frames[1].joints[0].coordinate;
  const double heat = 0.5 * kSpeed * kSpeed * kSled * kBox / (kSled + kBox);
  const BoundaryContactState contact = solver.boundary_contacts()[0];
  return {{"speed of the sled in the end", mean_rate(sled), common, 1e-3, Bound::relative, "m/s"},
          {"speed of the box in the end", mean_rate(box), common, 1e-3, Bound::relative, "m/s"},
          {"way of the box on the sled, v^2 / (2 mu g (1 + m/M))", slip,
           kSpeed * kSpeed / (2 * closing), 2e-3, Bound::relative, "m"},
          {"momentum", kSled * frames[0].joints[0].rate + kBox * frames[1].joints[0].rate,
           kSled * kSpeed, 1e-9, Bound::relative, "N s"},
          {"heat by friction", contact.dissipated_friction, heat, 1e-3, Bound::relative, "J"}};
}

// A drawer between two guides is pulled off-center.
struct Drawer {
  double length = 0.3, width = 0.4, clearance = 2e-5, rounding = 1e-3, offset = 0.15;
};

// x distance of the two corners that bear, once the drawer has turned as far as it can.
double bearing_length(const Drawer& d) {
  const double a = d.length / 2 - d.rounding, b = d.width / 2 - d.rounding;
  double turn = 0;
  for (int i = 0; i < 50; ++i) turn = std::asin((b + d.clearance - b * std::cos(turn)) / a);
  return 2 * (a * std::cos(turn) - b * std::sin(turn));
}

struct Pull {
  double acceleration = 0, distance = 0;          // m/s^2; m, in the last 0.2 s
  double work = 0, kinetic = 0, in_contacts = 0;  // J
};

// `damping` of the motion across the guides: it ends the rattling, and does nothing afterwards.
Pull pull_drawer(const Drawer& d, double friction, bool damping) {
  constexpr double kMass = 2, kForce = 20, kStiffness = 2e6;
  Model model = mechanism();
  model.gravity.setZero();
  Joint along = slider(Vec3::UnitX()), across = slider(Vec3::UnitY());
  Joint turning = hinge(Vec3::UnitZ());
  along.motors.push_back({});
  along.motors[0].speed = 1e3;  // never reached: a force
  along.motors[0].max_load = kForce;
  across.damping = damping ? 500 : 0;
  turning.damping = damping ? 20 : 0;
  const Vec3 inertia = box_inertia(kMass, {d.length, d.width, 0.1});
  // The drive pulls at the frame's origin.
  const int frame = add_mover(model, "drawer", kMass, Vec3::Zero(), inertia,
                              {along, across, turning}, {0, -d.offset, 0});
  const Vec3 half(d.length / 2, d.width / 2, 0.05);
  const int drawer = add_panel(model, "drawer", -half, half, d.rounding);
  model.boundaries[drawer].frame = frame;
  for (const double side : {1.0, -1.0}) {
    const double place = side * (half.y() + d.clearance);
    const int guide = add_plane(model, {0, place, 0}, -side * Vec3::UnitY());
    add_contact(model, drawer, guide, friction, 0.3, kStiffness);
  }
  model.timestep = 1e-5;
  Solver solver(model);
  double position[3] = {};
  for (double& at : position) {
    run(solver, solver.steps() == 0 ? 0.4 : 0.2);
    at = solver.frames()[0].joints[0].coordinate;
  }
  const FrameState now = solver.frames()[0];
  Pull out;
  out.acceleration = (position[2] - 2 * position[1] + position[0]) / (0.2 * 0.2);
  out.distance = position[2] - position[1];
  out.work = now.joints[0].motor_impulse / solver.time() * position[2];
  const Vec3 center_velocity =
      now.velocity + now.angular_velocity.cross(now.orientation * Vec3(0, d.offset, 0));
  out.kinetic = 0.5 * kMass * center_velocity.squaredNorm() +
                0.5 * inertia.z() * now.joints[2].rate * now.joints[2].rate;
  for (const BoundaryContactState& c : solver.boundary_contacts())
    out.in_contacts += c.dissipated_normal + c.dissipated_friction + c.elastic;
  return out;
}

std::vector<Check> binding() {
  constexpr double kFree = 20.0 / 2;  // m/s^2, without friction
  std::vector<Check> checks;
  for (const double offset : {0.15, 0.3, 0.6}) {
    Drawer d;
    d.offset = offset;
    const double critical = bearing_length(d) / (2 * offset);
    const std::string scene = fmt::format("L / (2 offset) = {:.4f}: ", critical);
    for (const double part : {0.5, 0.9, 0.98}) {
      const Pull pull = pull_drawer(d, part * critical, true);
      checks.push_back({scene + fmt::format("acceleration at {} of it", part), pull.acceleration,
                        kFree * (1 - part), 0.002 * kFree, Bound::absolute, "m/s^2"});
    }
    for (const double part : {1.02, 1.1, 2.0}) {
      checks.push_back({scene + fmt::format("way in 0.2 s at {} of it", part),
                        std::abs(pull_drawer(d, part * critical, true).distance), 5e-5, 0,
                        Bound::at_most, "m"});
    }
    const Pull pull = pull_drawer(d, 0.5 * critical, false);
    checks.push_back({scene + "energy of drawer and contacts over the work of the hand",
                      (pull.kinetic + pull.in_contacts) / pull.work, 1, 1e-3, Bound::relative});
  }
  return checks;
}

// An arm on a hinge rests with its tip on a slide, which is driven out and in below it.
struct Rest {
  double normal = 0, motor = 0, rate = 0;  // N, N, m/s
};

Rest arm_on_slide(double friction, double reach, double height, double speed, double limit) {
  constexpr double kMass = 0.2, kRadius = 0.005;
  Model model = mechanism();
  Joint pivot = hinge(Vec3::UnitY());
  pivot.damping = 0.1;  // of what rings on the springs of the contact
  const int arm = add_mover(model, "arm", kMass, {0.5 * reach, 0, height + kRadius},
                            Vec3::Constant(5e-4), {pivot}, {0, 0, height});
  Joint along = slider(Vec3::UnitX());
  along.motors.push_back({});
  along.motors[0].speed = speed;
  along.motors[0].max_load = limit;
  const int slide = add_mover(model, "slide", 0.5, {0, 0, -0.05}, Vec3::Constant(1e-3), {along});
  const int tip = add_ball(model, "tip", {reach, 0, kRadius}, kRadius, arm);
  const int bed = add_panel(model, "bed", {-1, -0.1, -0.1}, {1, 0.1, 0});
  model.boundaries[bed].frame = slide;
  add_contact(model, tip, bed, friction, 0.3, 1e6);
  model.timestep = 1e-5;
  Solver solver(model);
  run(solver, 0.3);
  const double before = solver.frames()[1].joints[0].coordinate;
  solver.clear_boundary_loads();
  run(solver, 0.1);
  const FrameState now = solver.frames()[1];
  return {std::abs(solver.boundary_contacts()[0].impulse.z()) / 0.1,
          now.joints[0].motor_impulse / 0.1, (now.joints[0].coordinate - before) / 0.1};
}

std::vector<Check> arm() {
  constexpr double kWeight = 0.2 * kGravity, kReach = 0.1, kHeight = 0.2, kSpeed = 0.1;
  std::vector<Check> checks;
  for (const double friction : {0.1, 0.3, 0.4}) {
    for (const double sign : {1.0, -1.0}) {
      const Rest rest = arm_on_slide(friction, kReach, kHeight, sign * kSpeed, 50);
      const double normal = kWeight * 0.5 * kReach / (kReach + sign * friction * kHeight);
      const std::string scene =
          fmt::format("friction {}, {}: ", friction, sign > 0 ? "out" : "in, against the arm");
      checks.push_back(
          {scene + "force of the arm", rest.normal, normal, 5e-3, Bound::relative, "N"});
      checks.push_back({scene + "force of the drive", sign * rest.motor, friction * normal, 5e-3,
                        Bound::relative, "N"});
    }
  }
  // Beyond reach / height the arm locks the slide, however strong its drive.
  for (const double limit : {5.0, 20.0}) {
    const Rest rest = arm_on_slide(0.55, kReach, kHeight, -kSpeed, limit);
    const std::string scene = fmt::format("friction 0.55, in, at most {} N: ", limit);
    checks.push_back(
        {scene + "speed", std::abs(rest.rate), 0.01 * kSpeed, 0, Bound::at_most, "m/s"});
    checks.push_back(
        {scene + "force of the drive", -rest.motor, limit, 1e-3, Bound::relative, "N"});
  }
  return checks;
}

}  // namespace

std::vector<VerificationCase> machine_cases() {
  std::vector<VerificationCase> all = {
      {.name = "machine.hammer",
       .title = "A hammer on a hinge strikes a wall",
       .reference = "-e' of the rate; F = v sqrt(m K), m = I / r^2; energy lost in the contact",
       .remark =
           "200 steps a quarter period of unloading. The contact of two boundaries has the law "
           "of particles, with the mass that the joint leaves to the point that is struck.",
       .run = hammer},
      {.name = "machine.sled",
       .title = "A box on a sled: friction between two jointed parts until they move alike",
       .reference = "momentum; v M / (M + m); v^2 / (2 mu g (1 + m/M)); heat m M v^2 / (2 (m + M))",
       .remark = "Forces on both parts are opposite, so that momentum is kept to rounding.",
       .run = sled},
      {.name = "machine.binding",
       .title = "A drawer pulled off-center binds",
       .reference =
           "self-locking at mu = L / (2 offset), L between the corners that bear; below it "
           "a = F / m (1 - 2 mu offset / L)",
       .remark =
           "Independent of the width and of the force. L accounts for rounded edges and for the "
           "turn that the clearance of 20 um allows. Ways: what "
           "the springs of friction let it move; 2 % below, it would slide by 16 mm. The "
           "energy is that of a drawer that rattles undamped.",
       .run = binding},
      {.name = "machine.arm",
       .title = "An arm rests on a slide that is driven out and in",
       .reference = "N = m g x / (l ± mu h); the drive bears mu N; the arm locks the way in from "
                    "mu = l / h on",
       .remark = "l and h: of the tip from the hinge, along the slide and across it.",
       .run = arm}};
  for (std::vector<VerificationCase> more :
       {drive_cases(), linkage_cases(), linkage_friction_cases()})
    all.insert(all.end(), std::make_move_iterator(more.begin()),
               std::make_move_iterator(more.end()));
  return all;
}

}  // namespace firn::verification
