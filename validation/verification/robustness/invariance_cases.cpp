// Invariance under equivalent setups: other axes, units, order, observers, steps, threads.
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "validation/verification/fixtures/closed_forms.h"
#include "validation/verification/robustness/cases.h"

namespace firn::verification {
namespace {

// Setup of a scene of crescents that fall between leaning walls.
struct Setup {
  Mat3 axes = Mat3::Identity();  // new axes of the old ones; a reflection mirrors the scene
  Vec3 origin = Vec3::Zero();    // m
  Vec3 boost = Vec3::Zero();     // m/s, of the observer, taken from every velocity
  double length = 1, mass = 1, time = 1;  // new units in old ones
  std::vector<int> order;                 // particle k of the setup is order[k] of the scene
  double timestep = 1e-5;                 // s, in old units
  double contact_update_fraction =
      0;  // 0: otherwise rounding decides when a contact search is made
  int bodies = 4;
  bool walls = true;
};

struct Places {
  std::vector<Vec3> position;  // in old axes and units, in the scene's order
  std::uint64_t patches = 0;
};

// Everything with a length, a mass or a time in it, in new units.
Model make_model(const Setup& t) {
  const double force = t.mass * t.length / (t.time * t.time);
  Model model = scenes::empty(scenes::law(0.2, 0.3), scenes::law(0.3, 0.3));
  for (Interaction& i : model.interactions) i.restick_velocity *= t.length / t.time;
  for (Material& m : model.materials) {
    m.density *= t.mass / std::pow(t.length, 3);
    m.young_modulus *= force / (t.length * t.length);
  }
  CrescentParameters p = named_crescent("mass-matched", {}).parameters;
  for (double* length : {&p.chord, &p.width, &p.depth, &p.tip_height, &p.top_concavity_depth})
    *length *= t.length;
  ShapeOptions options = scenes::ice_options(0, 0, 1e-3 * t.length);
  options.density = model.materials[scenes::kIce].density;
  options.young_modulus = model.materials[scenes::kIce].young_modulus;
  scenes::add_particles(model, scenes::add_shape(model, make_crescent(p, options)), t.bodies);
  model.numerics.contact_margin_limit *= t.length;
  const double sides[4][3] = {{-1, 0, -0.2}, {1, 0.1, -0.3}, {0.1, 1, -0.4}, {0.05, -1, -0.3}};
  const auto plane = [&](const Vec3& point, const Vec3& normal) {
    const int b = scenes::add_plane(model, t.axes * (t.length * point) + t.length * t.origin,
                                    t.axes * normal);
    if (t.boost.isZero()) return;
    Motion motion;
    motion.velocity = -t.length / t.time * (t.axes * t.boost);
    model.boundaries[b].motions.push_back(motion);
  };
  plane(Vec3::Zero(), Vec3::UnitZ());
  for (const auto& side : sides) {
    if (!t.walls) break;
    const Vec3 normal = -Vec3(side[0], side[1], side[2]).normalized();
    plane(-0.07 * normal, normal);
  }
  model.gravity = t.axes * model.gravity * t.length / (t.time * t.time);
  model.timestep = t.timestep * t.time;
  model.numerics.contact_update_fraction = t.contact_update_fraction;
  return model;
}

Places fall(const Setup& t, double duration) {
  const bool mirrored = t.axes.determinant() < 0;
  // The mirror image of a body is a body of the same shape (a crescent is symmetric in x), turned.
  const Mat3 flip = mirrored ? Mat3(Vec3(-1, 1, 1).asDiagonal()) : Mat3(Mat3::Identity());
  Solver solver(make_model(t));
  scenes::Random random(11);
  for (int i = 0; i < t.bodies; ++i) {
    const Mat3 turn = t.axes * random.orientation().toRotationMatrix() * flip;
    const Vec3 at(random.uniform(-0.02, 0.02), random.uniform(-0.02, 0.02), 0.04 + 0.066 * i);
    const Vec3 angular_velocity(3, -2, 1 + i), speed(0.1, 0.2, -0.5);
    const auto mine =
        t.order.empty()
            ? i
            : static_cast<int>(std::find(t.order.begin(), t.order.end(), i) - t.order.begin());
    solver.insert(mine, t.axes * (t.length * at) + t.length * t.origin, Quat(turn),
                  t.length / t.time * (t.axes * (speed - t.boost)),
                  t.axes.determinant() / t.time * (t.axes * angular_velocity));
  }
  scenes::run(solver, duration * t.time);
  Places out;
  out.patches = solver.diagnostics().patches;
  for (int i = 0; i < t.bodies; ++i) {
    const Vec3& p = solver.particles().position[t.order.empty() ? i : 0];
    out.position.push_back(p);
  }
  if (!t.order.empty()) {
    for (int k = 0; k < t.bodies; ++k) out.position[t.order[k]] = solver.particles().position[k];
  }
  for (Vec3& p : out.position) {
    p = t.axes.transpose() * (p / t.length - t.origin) + duration * t.boost;
  }
  return out;
}

double apart(const Places& a, const Places& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.position.size(); ++i)
    most = std::max(most, (a.position[i] - b.position[i]).norm());
  return most;
}

Check check(const std::string& what, const Setup& t, const Places& reference, double duration,
            double bound) {
  const Places got = fall(t, duration);
  if (got.patches == 0) throw RunError(what + ": nothing touches at the end");
  return {what, apart(got, reference), bound, 0, Bound::at_most, "m"};
}

constexpr double kFall = 0.16;  // s

std::vector<Check> other_axes() {
  const Places reference = fall({}, kFall);
  std::vector<Check> checks;
  Setup t;
  t.origin = {1.25, -3.5, 0.75};
  checks.push_back(check("moved by (1.25, -3.5, 0.75) m", t, reference, kFall, 1e-6));
  t = {};
  for (const auto& [angle, axis] :
       {std::pair{1.1, Vec3(1, -2, 0.5)}, {0.3, Vec3(0, 1, 1)}, {2.9, Vec3(-1, 0.2, 0.1)}}) {
    t.axes = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
    checks.push_back(check(fmt::format("turned by {} rad", angle), t, reference, kFall, 1e-6));
  }
  t = {};
  t.boost = {0.25, -0.5, 0.125};
  checks.push_back(check("seen from an observer who moves at 0.57 m/s", t, reference, kFall, 1e-6));
  return checks;
}

std::vector<Check> mirrored() {
  std::vector<Check> checks;
  for (const bool walls : {false, true}) {
    Setup plain;
    plain.walls = walls;
    Setup t = plain;
    t.axes = Vec3(-1, 1, 1).asDiagonal();
    checks.push_back(check(walls ? "between walls, mirrored in x" : "on a floor, mirrored in x", t,
                           fall(plain, kFall), kFall, 1e-6));
  }
  return checks;
}

std::vector<Check> other_units() {
  const Places reference = fall({}, kFall);
  std::vector<Check> checks;
  // Powers of two change no mantissa: the motion must be the same to the last bit.
  Setup t;
  t.length = 1024;
  t.mass = 64;
  t.time = 32;
  checks.push_back(check("units of 1/1024 m, 1/64 kg and 1/32 s", t, reference, kFall, 1e-6));
  t = {};
  t.length = 100;
  t.mass = 1000;
  checks.push_back(check("centimeter, gram, second", t, reference, kFall, 1e-6));
  t = {};
  t.length = 1e-3;
  t.time = 0.1;
  checks.push_back(check("kilometer, kilogram, ten seconds", t, reference, kFall, 1e-6));
  return checks;
}

std::vector<Check> other_order() {
  const Places reference = fall({}, kFall);
  std::vector<Check> checks;
  for (const std::vector<int>& order : {std::vector{3, 2, 1, 0}, std::vector{2, 0, 3, 1}}) {
    Setup t;
    t.order = order;
    checks.push_back(check(fmt::format("order {} {} {} {}", order[0], order[1], order[2], order[3]),
                           t, reference, kFall, 1e-6));
  }
  return checks;
}

// Crescents of several orientations thrown on a floor, through their first impacts.
std::vector<Check> halved_step() {
  constexpr int kThrows = 12;
  const std::array<double, 5> steps = {1e-5, 5e-6, 2.5e-6, 1.25e-6, 0.3125e-6};  // s
  std::array<double, 5> squares{};
  for (int k = 0; k < kThrows; ++k) {
    std::array<Vec3, 5> places;
    for (std::size_t i = 0; i < steps.size(); ++i) {
      Model model = scenes::body_on_plane(scenes::crescent(), scenes::law(0.2, 0.3));
      model.timestep = steps[i];
      model.numerics.contact_update_fraction = 0;
      Solver solver(model);
      scenes::Random random(11 + k);
      solver.insert(0, {0, 0, 0.04}, random.orientation(), {0.1, 0.2, -0.5}, {3, -2, 1});
      scenes::run(solver, 0.05);
      places[i] = solver.particles().position[0];
    }
    for (std::size_t i = 0; i < steps.size(); ++i)
      squares[i] += (places[i] - places.back()).squaredNorm() / kThrows;
  }
  std::vector<Check> checks;
  for (std::size_t i = 0; i + 1 < steps.size(); ++i) {
    checks.push_back(
        {fmt::format("step {:g} s: error of the place at 0.05 s, of {} throws", steps[i], kThrows),
         std::sqrt(squares[i]), 1e-4 * steps[i] / steps[0], 0, Bound::at_most, "m"});
  }
  checks.push_back({"observed order from 1e-5 to 1.25e-6 s", std::log2(squares[0] / squares[3]) / 6,
                    0.7, 0, Bound::at_least, "1"});
  return checks;
}

// 12 x 12 x 8 cubes land on each other: every phase of the step is shared out between threads.
Solver thrown_cubes(int threads) {
  constexpr int kSide = 12, kCubes = kSide * kSide * 8;
  Model model = scenes::empty(scenes::law(0.2, 0.3), scenes::law(0.2, 0.3));
  const Shape body = make_box(Vec3::Constant(0.02), scenes::ice_options(0.007, 2e5, 1e-3));
  scenes::add_particles(model, scenes::add_shape(model, body), kCubes);
  scenes::add_plane(model, Vec3::Zero(), Vec3::UnitZ());
  model.timestep = 1e-5;
  model.numerics.threads = threads;
  Solver solver(model);
  scenes::Random random(3);
  for (int i = 0; i < kCubes; ++i) {
    const Vec3 cell(i % kSide, i / kSide % kSide, i / (kSide * kSide));
    const Vec3 speed(random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), random.uniform(-1, 0));
    solver.insert(i, 0.0201 * (cell + Vec3::Constant(0.5)), Quat::Identity(), speed, Vec3::Zero());
  }
  return solver;
}

constexpr int kSteps = 60;

std::vector<std::uint64_t> hashes(int threads) {
  Solver solver = thrown_cubes(threads);
  std::vector<std::uint64_t> out;
  for (int k = 0; k < kSteps; ++k) {
    solver.step();
    out.push_back(solver.hash());
  }
  return out;
}

// More threads than there are cores get in each other's way, as they should here.
std::vector<Check> any_threads() {
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 16);
  const std::vector<std::uint64_t> one = hashes(1);
  std::vector<Check> checks;
  for (int threads = 2; threads <= 16; ++threads) {
    const std::vector<std::uint64_t> many = hashes(threads);
    double different = 0;
    for (std::size_t k = 0; k < one.size(); ++k) different += one[k] == many[k] ? 0 : 1;
    checks.push_back({fmt::format("{} threads: steps whose state differs in any bit, of {}",
                                  threads, one.size()),
                      different, 0, 0, Bound::absolute, "1"});
  }
  return checks;
}

// Saved and restored after any number of steps, a run ends in the same bytes.
std::vector<Check> any_interruption() {
  Solver solver = thrown_cubes(1);
  std::vector<std::vector<std::byte>> saved;
  for (int k = 0; k < kSteps; ++k) {
    solver.step();
    if (k % 10 == 3) saved.push_back(solver.save());
  }
  const std::uint64_t end = solver.hash();
  const std::uint64_t steps = solver.steps();
  double different = 0;
  for (const auto& bytes : saved) {
    Solver again(solver.model());
    again.restore(bytes);
    while (again.steps() < steps) again.step();
    if (again.hash() != end) ++different;
  }
  return {{fmt::format("ends that differ in any bit, of {}", saved.size()), different, 0, 0,
           Bound::absolute, "1"}};
}

}  // namespace

std::vector<VerificationCase> invariance_cases() {
  return {
      {"invariance.axes", "Moved, turned, and seen by a moving observer",
       "the same scene in the first axes",
       "Four crescents, five planes, 0.16 s: rounding errors grow a thousandfold with some "
       "impacts. Contacts are found in every step: otherwise "
       "rounding decides when they are searched.",
       Tier::quick, other_axes},
      {"invariance.mirror", "Mirrored", "the same scene in the first axes",
       "A friction or a spin of the wrong hand would move the bodies by centimeters.", Tier::quick,
       mirrored},
      {"invariance.units", "In other units of length, mass and time",
       "the same scene in SI: no constant in the solver has a unit", "", Tier::quick, other_units},
      {"invariance.order", "Particles numbered otherwise", "the same scene in the first order",
       "Sums are taken in another order: equal to rounding.", Tier::quick, other_order},
      {"invariance.step", "The time step halved", "a run with steps of 0.3 us",
       "An impact without friction is of second order (impact.time_step). Friction and the sharing "
       "out of a patch's stiffness follow the contact from one step to the next, which is of first "
       "order. Through the first impacts only; later on trajectories part by chance.",
       Tier::quick, halved_step},
      {"invariance.threads", "Any number of threads", "the bytes of the state, by their hash",
       "1152 cubes that land on each other, from 1 to 16 threads, at every step.", Tier::quick,
       any_threads},
      {"invariance.interruption", "Saved and gone on with at any step",
       "the bytes of the state at the end, by their hash", "", Tier::quick, any_interruption}};
}

}  // namespace firn::verification
