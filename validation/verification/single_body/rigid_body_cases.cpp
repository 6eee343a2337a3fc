// One rigid body: free flight, and impacts off its center.
#include <array>
#include <cmath>

#include "validation/verification/fixtures/closed_forms.h"
#include "validation/verification/single_body/cases.h"

namespace firn::verification {

std::vector<VerificationCase> incline_cases();  // incline_cases.cpp
std::vector<VerificationCase> rolling_cases();  // rolling_cases.cpp

namespace {

using scenes::kGravity;

// Angular velocity of a free body in body axes, rad/s.
Vec3 body_angular_velocity(const Solver& solver) {
  return solver.shape_orientation(0).conjugate() * solver.particles().angular_velocity[0];
}

Solver free_body(const Shape& shape, const Vec3& gravity, double timestep) {
  Model model = scenes::empty(scenes::law(0, 1), scenes::law(0, 1));
  scenes::add_particles(model, scenes::add_shape(model, shape));
  model.gravity = gravity;
  model.timestep = timestep;
  return Solver(model);
}

std::vector<Check> free_fall() {
  std::vector<Check> checks;
  for (const double dt : {1e-3, 1e-5}) {
    const Vec3 gravity(0.3, -0.2, -kGravity), start(1, 2, 3), speed(1, -2, 5);
    Solver solver = free_body(scenes::crescent(), gravity, dt);
    solver.insert(0, start, Quat::Identity(), speed, {3, 1, -2});
    scenes::run(solver, 1.0);
    const double t = solver.time();
    const Vec3 place = start + t * speed + 0.5 * t * t * gravity;
    const std::string scene = fmt::format("1 s in steps of {:g} s: ", dt);
    checks.push_back({scene + "distance from the parabola",
                      (solver.particles().position[0] - place).norm(), 1e-10, 0, Bound::at_most,
                      "m"});
    checks.push_back({scene + "error of the velocity",
                      (solver.particles().velocity[0] - speed - t * gravity).norm(), 1e-10, 0,
                      Bound::at_most, "m/s"});
  }
  return checks;
}

struct FreeRotation {
  std::vector<double> flips;                  // s, sign changes of the middle component
  double energy = 0, momentum = 0, turn = 0;  // largest relative errors; |q| - 1
};

FreeRotation rotate_freely(const Shape& shape, const Vec3& angular_velocity, double timestep,
                           double duration) {
  Solver solver = free_body(shape, Vec3::Zero(), timestep);
  solver.insert(0, Vec3::Zero(), Quat::Identity(), Vec3::Zero(), angular_velocity);
  const Quat axes = shape.shape_from_body;
  const auto momentum = [&] {
    const Quat q = solver.shape_orientation(0) * axes;
    const Vec3 w = q.conjugate() * solver.particles().angular_velocity[0];
    return Vec3(q * shape.inertia.cwiseProduct(w));
  };
  const Vec3 first = momentum();
  const double energy = solver.energy().kinetic;
  FreeRotation out;
  double before = body_angular_velocity(solver).y();
  while (solver.time() < duration) {
    solver.step();
    const double now = body_angular_velocity(solver).y();
    if (now * before < 0) out.flips.push_back(solver.time());
    before = now;
    if (solver.steps() % 100 != 0) continue;
    out.energy = std::max(out.energy, std::abs(solver.energy().kinetic / energy - 1));
    out.momentum = std::max(out.momentum, (momentum() - first).norm() / first.norm());
    out.turn = std::max(out.turn, std::abs(solver.particles().orientation[0].norm() - 1));
  }
  return out;
}

// Spin about the middle axis flips every 3.513899 s, first at 1.9861 s.
std::vector<Check> flipping_box() {
  const Shape box = make_box({0.3, 0.2, 0.1}, scenes::ice_options(1, 1e6, 1e-3));
  const FreeRotation got = rotate_freely(box, {0.01, 10, 0.01}, 5e-5, 10);
  std::vector<Check> checks;
  const Vec3 inertia(0.00416667, 0.00833333, 0.01083333);
  // The box's own axes; principal moments come in whatever order its body axes have.
  Vec3 sorted = box.inertia;
  std::sort(sorted.data(), sorted.data() + 3);
  for (int i = 0; i < 3; ++i) {
    checks.push_back({fmt::format("principal moment {}", i + 1), sorted[i], inertia[i], 1e-6,
                      Bound::relative, "kg m^2"});
  }
  const double flips[3] = {1.9861, 1.9861 + 3.513899, 1.9861 + 2 * 3.513899};
  for (std::size_t k = 0; k < std::min<std::size_t>(3, got.flips.size()); ++k) {
    checks.push_back({fmt::format("flip {} of the middle component", k + 1), got.flips[k], flips[k],
                      1e-3, Bound::absolute, "s"});
  }
  checks.push_back(
      {"flips within 10 s", static_cast<double>(got.flips.size()), 3, 0, Bound::at_least, "1"});
  checks.push_back(
      {"largest relative error of the energy", got.energy, 1e-6, 0, Bound::at_most, "1"});
  checks.push_back({"largest relative error of the angular momentum", got.momentum, 1e-6, 0,
                    Bound::at_most, "1"});
  return checks;
}

// A crescent tumbling fast, in steps as long as its contacts need.
std::vector<Check> tumbling() {
  std::vector<Check> checks;
  for (const double speed : {10.0, 100.0}) {
    const FreeRotation got =
        rotate_freely(scenes::crescent(), speed * Vec3(0.3, 0.8, -0.5), 2e-5, 2);
    const std::string scene = fmt::format("{} rad/s, 2 s: ", speed);
    checks.push_back({scene + "largest relative error of the energy", got.energy,
                      1e-9 * speed * speed, 0, Bound::at_most, "1"});
    checks.push_back({scene + "largest relative error of the angular momentum", got.momentum, 1e-11,
                      0, Bound::at_most, "1"});
    checks.push_back(
        {scene + "length of the quaternion less one", got.turn, 1e-12, 0, Bound::at_most, "1"});
  }
  return checks;
}

// A body of one effective contact lands on a frictionless plane at 1 m/s without gravity.
struct Landing {
  std::string name;
  Vec3 size = Vec3::Zero();
  Quat turn = Quat::Identity();
  Vec3 lowest = Vec3::Zero();  // middle of what touches first, in halves of the core's edges
};

// J = m_eff (1 + e) v, 1 / m_eff = 1/m + (r x n) . I^-1 (r x n).
void land(const Landing& in, double e, std::vector<Check>& checks) {
  const double stiffness = 1e9, rounding = 1e-5;
  const Shape shape = make_box(in.size, scenes::ice_options(1, stiffness, rounding));
  Model model = scenes::body_on_plane(shape, scenes::law(0, e));
  model.gravity.setZero();
  model.timestep = 0.3e-6 * e / 0.5;
  Solver solver(model);
  const Vec3 half = 0.5 * in.size - Vec3::Constant(rounding);
  const Vec3 arm = in.turn * in.lowest.cwiseProduct(half);
  solver.insert(0, {0, 0, rounding - arm.z() + 1e-9}, in.turn, {0, 0, -1}, Vec3::Zero());
  scenes::run(solver, 1e-3);
  const Mat3 r = in.turn.toRotationMatrix();
  const Mat3 inverse = r * box_inertia(1, in.size).cwiseInverse().asDiagonal() * r.transpose();
  const Vec3 lever = arm.cross(Vec3::UnitZ());
  const double effective = 1 / (1 + lever.dot(inverse * lever));
  const double impulse = effective * (1 + restitution_with_floor(e));
  const Vec3 angular_velocity = impulse * (inverse * lever);
  const ParticleState& p = solver.particles();
  const std::string scene = fmt::format("{}, e = {}: ", in.name, e);
  checks.push_back(
      {scene + "speed after", p.velocity[0].z(), -1 + impulse, 2e-3, Bound::absolute, "m/s"});
  checks.push_back({scene + "error of the spin after",
                    (p.angular_velocity[0] - angular_velocity).norm(),
                    5e-3 * angular_velocity.norm() + 1e-6, 0, Bound::at_most, "rad/s"});
  // One patch has the whole stiffness, whether one, two or four vertices carry it.
  checks.push_back({scene + "largest force", p.peak_normal_force[0],
                    std::sqrt(effective * stiffness), 3e-3, Bound::relative, "N"});
}

std::vector<Check> off_center() {
  std::vector<Check> checks;
  const Vec3 cube = Vec3::Constant(0.1);
  for (const double e : {0.3, 0.5, 0.8}) {
    land({"cube on a face", cube, Quat::Identity(), {0, 0, -1}}, e, checks);
    for (const double tilt : {5.0, 10.0, 20.0, 30.0, 45.0}) {
      land({fmt::format("cube on an edge, {} deg", tilt),
            cube,
            about(Vec3::UnitY(), tilt),
            {1, 0, -1}},
           e, checks);
    }
    for (const auto& [roll, pitch] : {std::array{-25.0, 20.0}, {-10.0, 35.0}, {-40.0, 5.0}}) {
      const Quat turn = about(Vec3::UnitX(), roll) * about(Vec3::UnitY(), pitch);
      land({fmt::format("cube on a corner, {} and {} deg", roll, pitch), cube, turn, {1, 1, -1}}, e,
           checks);
      land({fmt::format("box .3 x .2 x .1 on a corner, {} and {} deg", roll, pitch),
            {0.3, 0.2, 0.1},
            turn,
            {1, 1, -1}},
           e, checks);
    }
  }
  return checks;
}

}  // namespace

std::vector<VerificationCase> body_cases() {
  std::vector<VerificationCase> cases = {
      {"body.free_fall", "A crescent in free fall", "x0 + v t + g t^2 / 2, to rounding",
       "Leapfrog is exact for constant acceleration.", Tier::quick, free_fall},
      {"body.flipping_box", "A box that spins about its middle axis, free of torque",
       "Euler's equations in elliptic functions: period 7.027797 s, first flip at 1.9861 s",
       "Box .3 x .2 x .1 m, 1 kg, spin (.01, 10, .01) rad/s, 10 s in steps of 5e-5 s. A flip is "
       "exponentially sensitive: the bound of 1 ms is one of the published first flip's digits.",
       Tier::quick, flipping_box},
      {"body.tumbling", "A crescent that tumbles, free of torque",
       "energy and angular momentum are kept",
       "The step of the drained bed, 2e-5 s. The momentum is kept by construction, the energy to "
       "second order in the angle turned per step.",
       Tier::quick, tumbling},
      {"body.off_center", "Cubes and boxes land on a face, an edge or a corner, without friction",
       "J = m_eff (1 + e') v, 1/m_eff = 1/m + (r x n) I^-1 (r x n); F = v sqrt(m_eff K)",
       "An edge or face is one patch and has the stiffness K once: the force does not grow with "
       "the "
       "number of its vertices. K = 1e9 N/m, so that the lever arm hardly turns while it touches.",
       Tier::quick, off_center}};
  for (auto* more : {incline_cases, rolling_cases}) {
    for (VerificationCase& c : more()) cases.push_back(std::move(c));
  }
  return cases;
}

}  // namespace firn::verification
