// One rigid body on an incline: it stays, slides, stops, or spins down.
#include <algorithm>
#include <cmath>
#include <random>

#include "validation/verification/fixtures/closed_forms.h"

namespace firn::verification {

std::vector<VerificationCase> incline_cases();

namespace {

using scenes::kGravity;

// A box of 1 kg on z = 0, gravity leaning by `degrees` towards +x, resting in its own dent.
Solver on_incline(const Vec3& size, double degrees, const Interaction& law, double speed,
                  double rounding = 1e-3) {
  const double stiffness = 1e6, angle = degrees * kDegToRad;
  Model model =
      scenes::body_on_plane(make_box(size, scenes::ice_options(1, stiffness, rounding)), law);
  model.gravity = kGravity * Vec3(std::sin(angle), 0, -std::cos(angle));
  model.timestep = 2e-5;
  Solver solver(model);
  const double dent = kGravity * std::cos(angle) / stiffness;
  solver.insert(0, {0, 0, size.z() / 2 - dent}, Quat::Identity(), {speed, 0, 0}, Vec3::Zero());
  return solver;
}

const Vec3 kCube = Vec3::Constant(0.1);

std::vector<Check> sliding() {
  constexpr double kSpan = 0.25;  // s
  std::vector<Check> checks;
  const double rows[6][3] = {{20, 0.3, 0.589702}, {30, 0.5, 0.657145}, {45, 0.6, 2.774687},
                             {10, 0.0, 0},        {35, 0.1, 0},        {40, 0.7, 0}};
  for (const auto& [degrees, mu, published] : rows) {
    Solver solver = on_incline(kCube, degrees, scenes::law(mu, 0.5), 0);
    // The block rocks on its springs, as nothing damps it: mean velocities of two spans.
    const auto mean_velocity = [&solver] {
      const double from = solver.particles().position[0].x(), begin = solver.time();
      scenes::run(solver, kSpan);
      return (solver.particles().position[0].x() - from) / (solver.time() - begin);
    };
    scenes::run(solver, 0.2);
    const double before = mean_velocity();
    const double got = (mean_velocity() - before) / kSpan;
    const double expected =
        kGravity * (std::sin(degrees * kDegToRad) - mu * std::cos(degrees * kDegToRad));
    const std::string scene = fmt::format("{} deg, mu = {}: ", degrees, mu);
    checks.push_back({scene + "acceleration", got, published > 0 ? published : expected, 2e-3,
                      Bound::relative, "m/s^2"});
    checks.push_back({scene + "drift to the side", std::abs(solver.particles().position[0].y()),
                      1e-9, 0, Bound::at_most, "m"});
  }
  return checks;
}

// The same box on a plane that leans over slowly, so that nothing rings: an incline that is there
// at once loads the friction spring up to twice what it must bear. Returns how far the box has slid
// down by the end of the lean, and in the second after it.
struct Lean {
  double during = 0, after = 0;  // m
};
Lean lean(double degrees, const Interaction& law) {
  constexpr double kRate = 1;  // deg/s
  Model model = scenes::body_on_plane(make_box(kCube, scenes::ice_options(1, 1e6, 1e-3)), law);
  Motion tilt;
  tilt.kind = Motion::Kind::rotation;
  tilt.axis = Vec3::UnitY();
  tilt.angular_speed = kRate * kDegToRad;
  tilt.stop = degrees / kRate;
  model.boundaries[0].motions = {tilt};
  model.timestep = 2e-5;
  Solver solver(model);
  solver.insert(0, {0, 0, 0.05 - kGravity / 1e6}, Quat::Identity(), Vec3::Zero(), Vec3::Zero());
  const auto place = [&] {  // along the plane, about whose origin it turns
    return (solver.boundaries()[0].orientation.conjugate() * solver.particles().position[0]).x();
  };
  scenes::run(solver, tilt.stop + 0.1);
  Lean out;
  out.during = place();
  scenes::run(solver, 1.0);
  out.after = place() - out.during;
  return out;
}

std::vector<Check> staying() {
  std::vector<Check> checks;
  for (const auto& [degrees, mu] : {std::pair{15.0, 0.3}, {5.0, 0.1}, {26.0, 0.6}}) {
    const std::string scene = fmt::format("{} deg, mu = {}: ", degrees, mu);
    const Lean got = lean(degrees, scenes::law(mu, 0.5));
    checks.push_back(
        {scene + "creep in 1 s after leaning over", got.after, 1e-6, 0, Bound::at_most, "m"});
  }
  Solver sudden = on_incline(kCube, 15, scenes::law(0.3, 0.5), 0);
  scenes::run(sudden, 0.5);
  const Vec3 before = sudden.particles().position[0];
  scenes::run(sudden, 1.0);
  checks.push_back({"15 deg, mu = 0.3, incline there at once: creep in 1 s",
                    (sudden.particles().position[0] - before).norm(), 1e-6, 0, Bound::at_most,
                    "m"});
  const Lean slides = lean(17.2, scenes::law(0.3, 0.5));
  checks.push_back(
      {"17.2 deg, mu = 0.3: slides in 1 s at least half a t^2 / 2", slides.after,
       0.25 * kGravity * (std::sin(17.2 * kDegToRad) - 0.3 * std::cos(17.2 * kDegToRad)), 0,
       Bound::at_least, "m"});
  return checks;
}

// v^2 / (2 mu g) in v / (mu g). What is left then is the ring of the tangential spring, of
// amplitude mu m g / K.
std::vector<Check> stopping() {
  std::vector<Check> checks;
  for (const auto& [speed, mu] : {std::pair{2.0, 0.4}, {1.0, 0.2}, {0.5, 0.8}}) {
    Solver solver = on_incline(kCube, 0, scenes::law(mu, 0.5), speed);
    const double time = speed / (mu * kGravity);
    double stopped = 0;
    while (solver.time() < time + 0.1) {
      solver.step();
      if (stopped == 0 && solver.particles().velocity[0].x() <= 0) stopped = solver.time();
    }
    const double stop = solver.particles().position[0].x();
    const std::string scene = fmt::format("{} m/s, mu = {}: ", speed, mu);
    checks.push_back(
        {scene + "way", stop, speed * speed / (2 * mu * kGravity), 2e-3, Bound::relative, "m"});
    // The block nods on its springs, which moves its center of mass a little.
    checks.push_back({scene + "time", stopped, time, 1e-3, Bound::absolute, "s"});
    scenes::run(solver, 0.3);
    checks.push_back({scene + "creep after", std::abs(solver.particles().position[0].x() - stop),
                      3 * mu * kGravity / 1e6, 0, Bound::at_most, "m"});
  }
  return checks;
}

// A static coefficient of 0.5 and a dynamic one of 0.3: at 25 degrees a block at rest stays and a
// sliding one keeps sliding; at 15 a sliding one stops.
std::vector<Check> static_and_dynamic() {
  Interaction law = scenes::law(0.3, 0.5);
  law.static_friction = 0.5;
  std::vector<Check> checks;
  const Lean rests = lean(20, law);
  checks.push_back({"20 deg (tan 20 = 0.36), leaning over: creep in 1 s", rests.after, 1e-6, 0,
                    Bound::at_most, "m"});
  const Lean starts = lean(27, law);
  checks.push_back({"27 deg (tan 27 = 0.51), leaning over: slides in 1 s", starts.after,
                    0.5 * kGravity * (std::sin(27 * kDegToRad) - 0.3 * std::cos(27 * kDegToRad)), 0,
                    Bound::at_least, "m"});
  Solver slides = on_incline(kCube, 25, law, 0.5);
  scenes::run(slides, 0.1);
  const double speed = slides.particles().velocity[0].x();
  scenes::run(slides, 0.4);
  checks.push_back({"25 deg, from 0.5 m/s: acceleration",
                    (slides.particles().velocity[0].x() - speed) / 0.4,
                    kGravity * (std::sin(25 * kDegToRad) - 0.3 * std::cos(25 * kDegToRad)), 2e-3,
                    Bound::relative, "m/s^2"});
  Solver stops = on_incline(kCube, 15, law, 0.3);
  const double brake = kGravity * (0.3 * std::cos(15 * kDegToRad) - std::sin(15 * kDegToRad));
  scenes::run(stops, 0.3 / brake + 0.1);
  checks.push_back({"15 deg, from 0.3 m/s: way to rest", stops.particles().position[0].x(),
                    0.09 / (2 * brake), 2e-3, Bound::relative, "m"});
  return checks;
}

// Uniform pressure: moment mu m g a times 0.382598.
std::vector<Check> spin_down() {
  std::vector<Check> checks;
  const double edge = 0.1, stiffness = 1e6;
  for (const double mu : {0.1, 0.3}) {
    for (const double rounding : {1e-4, 1e-3}) {
      Model model = scenes::body_on_plane(cube(edge, 1, stiffness, rounding), scenes::law(mu, 0.5));
      model.timestep = 2e-5;
      Solver solver(model);
      solver.insert(0, {0, 0, edge / 2 - kGravity / stiffness}, Quat::Identity(), Vec3::Zero(),
                    {0, 0, 20});
      scenes::run(solver, 0.05);
      const double before = solver.particles().angular_velocity[0].z();
      scenes::run(solver, 0.15);
      // The flat that bears is what the rounding leaves of the face.
      const double flat = edge - 2 * rounding;
      const double expected = 0.382598 * mu * kGravity * flat / (edge * edge / 6);
      checks.push_back(
          {fmt::format("mu = {}, edges rounded by {} mm: spin lost per second", mu, 1e3 * rounding),
           (before - solver.particles().angular_velocity[0].z()) / 0.15, expected, 0.015,
           Bound::relative, "rad/s^2"});
    }
  }
  return checks;
}

// Coulomb friction on a uniform rectangle that slides at `speed` (m/s) at an angle (rad) to its
// first edge and turns at `omega` (rad/s): integrated over the face at every step. Returns the
// displacement of its center (m) until both have stopped.
Eigen::Vector2d integrated_way(double a, double b, double mu, double speed, double angle,
                               double omega) {
  constexpr int kCells = 40;
  constexpr double dt = 2e-5;
  const double inertia = (a * a + b * b) / 12;  // per mass
  Eigen::Vector2d v(speed, 0), slide(0, 0);
  double turned = -angle;
  for (double w = omega; v.norm() > 1e-3 || std::abs(w) * a > 1e-3;) {
    Eigen::Vector2d force(0, 0);
    double moment = 0;
    for (int i = 0; i < kCells; ++i) {
      for (int k = 0; k < kCells; ++k) {
        const Eigen::Vector2d at =
            Eigen::Rotation2Dd(turned) *
            Eigen::Vector2d(a * ((i + 0.5) / kCells - 0.5), b * ((k + 0.5) / kCells - 0.5));
        const Eigen::Vector2d slip = v + w * Eigen::Vector2d(-at.y(), at.x());
        const double size = slip.norm();
        if (!(size > 0)) continue;
        const Eigen::Vector2d pull = slip * (-mu * kGravity / (kCells * kCells * size));
        force += pull;
        moment += at.x() * pull.y() - at.y() * pull.x();
      }
    }
    slide += dt * v;
    turned += dt * w;
    v += dt * force;
    w += dt * moment / inertia;
  }
  return slide;
}

// Displacement (m) of the center of a plate of edges `a` and `b` (m) until it has come to rest,
// flat on z = 0, so that friction at its foot does not shift the load. Speed in m/s at an angle
// (rad) to its first edge, angular velocity `omega` in rad/s.
Eigen::Vector2d simulated_way(double a, double b, double mu, double speed, double angle,
                              double omega) {
  constexpr double stiffness = 1e6, rounding = 1e-5, mass = 0.1;
  const Shape plate = make_box({a, b, 1e-3}, scenes::ice_options(mass, stiffness, rounding));
  Model model = scenes::body_on_plane(plate, scenes::law(mu, 0.5));
  model.timestep = 2e-5;
  Solver solver(model);
  solver.insert(0, {0, 0, 0.5e-3 - mass * kGravity / stiffness},
                about(Vec3::UnitZ(), -angle / kDegToRad), {speed, 0, 0}, {0, 0, omega});
  scenes::run(solver, 1.5);
  const Vec3& place = solver.particles().position[0];
  return place.head<2>();
}

std::vector<Check> slide_and_spin() {
  constexpr double mu = 0.3, speed = 0.5;
  std::vector<Check> checks;
  for (const auto& [a, b] : {std::array{40e-3, 40e-3}, {60e-3, 30e-3}, {60e-3, 12e-3}}) {
    for (const double angle : {0.0, 45.0}) {
      for (const double omega : {0.0, 10.0, 20.0, 60.0, 120.0}) {
        checks.push_back({fmt::format("{:g} x {:g} mm at {:g} deg, {:g} rad/s: way", 1e3 * a,
                                      1e3 * b, angle, omega),
                          simulated_way(a, b, mu, speed, angle * kDegToRad, omega).norm(),
                          integrated_way(a, b, mu, speed, angle * kDegToRad, omega).norm(), 0.02,
                          Bound::relative, "m"});
      }
    }
  }
  return checks;
}

// Random plates up to 10 : 1. A plate that is not square also drifts to a side.
std::vector<Check> many_slide_and_spin() {
  constexpr int kPlates = 100;
  std::mt19937_64 random(2026);
  std::uniform_real_distribution<double> unit(0, 1);
  const auto between = [&](double low, double high) { return low + (high - low) * unit(random); };
  std::vector<double> off;
  for (int i = 0; i < kPlates; ++i) {
    const double a = between(30e-3, 60e-3), b = a / std::exp(between(0, std::log(10)));
    const double mu = between(0.2, 0.5), speed = between(0.2, 0.6);
    const double angle = between(0, 90) * kDegToRad, omega = between(0, 4) * speed / a;
    const Eigen::Vector2d expected = integrated_way(a, b, mu, speed, angle, omega);
    off.push_back((simulated_way(a, b, mu, speed, angle, omega) - expected).norm() /
                  expected.norm());
  }
  std::sort(off.begin(), off.end());
  const auto share = [&](double part) {
    return off[static_cast<std::size_t>(std::lround(part * (kPlates - 1)))];
  };
  return {
      {"median deviation of the displacement", share(0.5), 0.01, 0, Bound::at_most, ""},
      {"deviation of the displacement, 95 of 100 plates", share(0.95), 0.03, 0, Bound::at_most, ""},
      {"largest deviation of the displacement", off.back(), 0.05, 0, Bound::at_most, ""}};
}

}  // namespace

std::vector<VerificationCase> incline_cases() {
  return {
      {"body.sliding", "A block slides down an incline", "a = g (sin t - mu cos t)", "",
       Tier::quick, sliding},
      {"body.staying", "A block below the friction angle stays", "creep below 1 um in 1 s",
       "16.6 degrees is 0.1 below the friction angle of 0.3. The hysteretic spring does not damp "
       "what "
       "stays below its largest load, so that a block that is put on an incline rings, and near "
       "the "
       "friction angle creeps in the troughs; one that is leant over slowly does not.",
       Tier::quick, staying},
      {"body.stopping", "A sliding block comes to rest", "v^2 / (2 mu g) in v / (mu g)",
       "What is left is the ring of the tangential spring, mu m g / K, and the block's rocking on "
       "its normal "
       "springs, which nothing damps.",
       Tier::quick, stopping},
      {"body.static_and_dynamic", "Static and dynamic friction are two numbers",
       "g (sin t - mu_d cos t) once it slides; rest while tan t < mu_s", "", Tier::quick,
       static_and_dynamic},
      {"body.spin_down", "A cube that spins on its face",
       "moment mu m g a 0.382598, that of uniform pressure (four corners: 0.707107)",
       "The contact assumes uniform pressure over the face that touches, by one torsional spring "
       "whose radius follows from the patch's second moment: exact to about 1 %.",
       Tier::quick, spin_down},
      {"body.slide_and_spin", "A plate that slides and spins",
       "Coulomb friction of uniform pressure, integrated over the face at every step",
       "Force and torsion share one limit, which depends on the elongation of the face and on the "
       "direction "
       "of sliding along or across it.",
       Tier::quick, slide_and_spin},
      {"body.many_slide_and_spin", "Random plates that slide and spin",
       "Coulomb friction of uniform pressure, integrated over the face at every step",
       "100 plates up to 10 : 1; the displacement includes the drift to a side.", Tier::full,
       many_slide_and_spin}};
}

}  // namespace firn::verification
