// One contact: normal impact and slow squeezing of spheres, against the hysteretic spring's closed
// forms (equations (3) to (7) of docs/contact.md).
#include <algorithm>
#include <array>
#include <cmath>

#include "validation/verification/fixtures/closed_forms.h"
#include "validation/verification/single_body/cases.h"

namespace firn::verification {

std::vector<VerificationCase> oblique_cases();       // oblique_impact_cases.cpp
std::vector<VerificationCase> impact_floor_cases();  // unloading_floor_cases.cpp

namespace {

using scenes::kGravity;

struct Impact {
  double overlap = 0;       // m, largest
  double force = 0;         // N, largest
  double rebound = 0;       // m/s
  double contact_time = 0;  // s with more force than the floor can give
  double overlap_time = 0;  // s with an overlap
  double residual = 0;      // m, overlap when the force falls to the floor's
  double impulse = 0;       // N s
  double loss = 0;          // J
};

struct ImpactScene {
  double mass = 1, speed = 1, stiffness = 1e5, e = 0.5, floor = 0.001;
  double steps = 200;  // per quarter period of unloading
  double phase = 0.4;  // of a step, until first touch
};

Impact drop(const ImpactScene& in) {
  const double radius = 0.05;
  Interaction law = scenes::law(0, in.e);
  law.minimum_unloading_ratio = in.floor;
  Model model = scenes::body_on_plane(sphere(radius, in.mass, in.stiffness), law);
  model.gravity.setZero();
  const double dt = model.timestep = quarter_period(in.mass, in.stiffness) * in.e / in.steps;
  model.numerics.overlap_limit = 1;
  Solver solver(model);
  solver.insert(0, {0, 0, radius + in.phase * in.speed * dt}, Quat::Identity(), {0, 0, -in.speed},
                Vec3::Zero());
  // The floor bears lambda K s at most.
  const double floor_force = 2 * in.floor * in.speed * std::sqrt(in.mass * in.stiffness);
  Impact out;
  for (double before = -in.speed; solver.steps() < 1000000;) {
    solver.step();
    const ParticleState& p = solver.particles();
    const double now = p.velocity[0].z(), overlap = radius - p.position[0].z();
    const double force = in.mass * (now - before) / dt;
    out.overlap = std::max(out.overlap, overlap);
    if (overlap > 0) out.overlap_time += dt;
    if (force > floor_force) {
      out.contact_time += dt;
      out.residual = overlap;
    }
    before = now;
    if (now > 0 && overlap < 0) break;
  }
  out.force = solver.particles().peak_normal_force[0];
  out.rebound = solver.particles().velocity[0].z();
  out.impulse = in.mass * (in.speed + out.rebound);
  const Energy e = solver.energy();
  out.loss = e.dissipated_normal + e.dissipated_friction;
  return out;
}

std::vector<Check> normal_impact() {
  std::vector<Check> checks;
  for (const double e : {0.1, 0.3, 0.5, 0.8, 1.0}) {
    const auto named = [&](const char* what) { return fmt::format("e = {}: {}", e, what); };
    LargestError overlap(named("largest overlap / (v sqrt(m/K))"), 1e-4);
    LargestError force(named("largest force / (v sqrt(m K))"), 1e-4);
    LargestError time(named("contact time / ((1 + e) pi/2 sqrt(m/K))"), 8e-3);
    LargestError rebound(named("rebound speed / (e' v)"), 1e-3 / e);
    LargestError residual(named("residual overlap / ((1 - e^2) largest)"), 8e-3);
    LargestError loss(named("energy lost / (m v^2 (1 - e'^2) / 2)"), 1e-3);
    const double floored = restitution_with_floor(e);
    for (const double mass : {0.0137, 0.05, 1.0}) {
      for (const double stiffness : {2e4, 1e5, 1e6}) {
        for (const double speed : {0.1, 1.0, 2.0}) {
          const std::string where = fmt::format("m {} K {:g} v {}", mass, stiffness, speed);
          const Impact got = drop({.mass = mass, .speed = speed, .stiffness = stiffness, .e = e});
          const double deepest = speed * std::sqrt(mass / stiffness);
          overlap.add(got.overlap, deepest, where);
          force.add(got.force, speed * std::sqrt(mass * stiffness), where);
          time.add(got.contact_time, (1 + e) * quarter_period(mass, stiffness), where);
          rebound.add(got.rebound, floored * speed, where);
          if (e < 1) residual.add(got.residual, (1 - e * e) * deepest, where);
          if (e < 1)
            loss.add(got.loss, 0.5 * mass * speed * speed * (1 - floored * floored), where);
        }
      }
    }
    for (const LargestError& w : {overlap, force, time, rebound}) checks.push_back(w.check());
    if (e < 1) checks.push_back(residual.check());
    if (e < 1) checks.push_back(loss.check());
  }
  return checks;
}

std::vector<Check> published_impacts() {
  std::vector<Check> checks;
  // mass, speed, stiffness, e; largest overlap, force, time, residual overlap, loss.
  const double rows[2][9] = {
      {1, 1, 1e5, 0.5, 3.162278e-3, 316.2278, 7.450941e-3, 2.371708e-3, 0.375},
      {0.05, 3, 2e4, 0.3, 4.743416e-3, 94.86833, 3.228741e-3, 4.316509e-3, 0.20475}};
  for (const auto& r : rows) {
    const Impact got = drop({.mass = r[0], .speed = r[1], .stiffness = r[2], .e = r[3]});
    const std::string scene =
        fmt::format("m = {} kg, v = {} m/s, K = {:g} N/m, e = {}: ", r[0], r[1], r[2], r[3]);
    checks.push_back({scene + "largest overlap", got.overlap, r[4], 1e-4, Bound::relative, "m"});
    checks.push_back({scene + "largest force", got.force, r[5], 1e-4, Bound::relative, "N"});
    checks.push_back({scene + "contact time", got.contact_time, r[6], 8e-3, Bound::relative, "s"});
    checks.push_back({scene + "residual overlap", got.residual, r[7], 8e-3, Bound::relative, "m"});
    // Without the floor; it gives back a little more.
    const double floored = restitution_with_floor(r[3]);
    const double less = 0.5 * r[0] * r[1] * r[1] * (floored * floored - r[3] * r[3]);
    checks.push_back({scene + "energy lost, without the floor", got.loss + less, r[8], 1e-3,
                      Bound::relative, "J"});
    checks.push_back({scene + "impulse, without the floor",
                      got.impulse - r[0] * r[1] * (floored - r[3]), r[0] * r[1] * (1 + r[3]), 1e-3,
                      Bound::relative, "N s"});
  }
  return checks;
}

// Time with an overlap over the time of the spring without a floor. After the fall along K_u (zero
// force at (1 - e^2) s_max, frequency w2 = sqrt(K_u/m)) the floor is a soft spring of frequency w3.
double lengthening(double e, double lambda) {
  const double r = (1 - e * e) / (1 - lambda * e * e);
  const double w2 = 1 / e, w3 = std::sqrt(lambda);  // in units of sqrt(K/m), lengths of s_max
  const double y0 = e * e, y1 = r - (1 - e * e);
  const double t2 = std::acos(y1 / y0) / w2, v1 = y0 * w2 * std::sin(w2 * t2);
  const double t3 = std::atan2(r * w3, v1) / w3;
  const double half_pi = 0.5 * std::numbers::pi;
  return (half_pi + t2 + t3) / (half_pi * (1 + e));
}

std::vector<Check> unloading_floor() {
  std::vector<Check> checks;
  for (const double lambda : {0.001, 0.01, 0.1}) {
    for (const double e : {0.1, 0.3, 0.5, 0.8}) {
      const Impact got = drop({.e = e, .floor = lambda, .steps = 400});
      const std::string scene = fmt::format("lambda = {}, e = {}: ", lambda, e);
      checks.push_back({scene + "restitution", got.rebound, restitution_with_floor(e, lambda), 1e-3,
                        Bound::relative, "1"});
      checks.push_back({scene + "time of overlap over that without a floor",
                        got.overlap_time / ((1 + e) * quarter_period(1, 1e5)),
                        lengthening(e, lambda), 5e-3, Bound::relative, "1"});
    }
  }
  const double published[3][3] = {
      {0.5, 0.500562, 1.64}, {0.3, 0.301377, 2.48}, {0.1, 0.104786, 6.55}};
  for (const auto& [e, restitution, longer] : published) {
    checks.push_back({fmt::format("closed form of the restitution at e = {}", e),
                      restitution_with_floor(e), restitution, 1e-6, Bound::absolute, "1"});
    checks.push_back({fmt::format("closed form of the lengthening at e = {}", e),
                      lengthening(e, 0.001), longer, 5e-3, Bound::absolute, "1"});
  }
  return checks;
}

// Leapfrog is of second order, and so is the whole impact, first touch and change of spring
// included.
std::vector<Check> time_step() {
  std::vector<Check> checks;
  for (const double e : {0.3, 0.5, 0.8}) {
    double coarse = 0;
    for (const double steps : {10.0, 20.0, 40.0, 80.0}) {
      // Over all phases of the first touch within a step; a single phase may be accurate by chance.
      constexpr int kPhases = 16;
      double squares = 0;
      for (int k = 0; k < kPhases; ++k) {
        const Impact got = drop({.e = e, .steps = steps, .phase = (k + 0.5) / kPhases});
        squares += std::pow(got.rebound - restitution_with_floor(e), 2);
      }
      const double error = std::sqrt(squares / kPhases);
      checks.push_back({fmt::format("e = {}, {} steps a quarter period: error of e", e, steps),
                        error, 0.5 / (steps * steps), 0, Bound::at_most, "1"});
      if (steps == 10) coarse = error;
      if (steps == 80) {
        checks.push_back({fmt::format("e = {}: observed order from 10 to 80 steps", e),
                          std::log2(coarse / error) / 3, 1.8, 0, Bound::at_least, "1"});
      }
    }
  }
  return checks;
}

// v1' = V - (m2/M) e (v1 - v2) and so on; F_max = v_rel sqrt(m* K) with the stiffnesses in series.
std::vector<Check> two_bodies() {
  std::vector<Check> checks;
  const double radius = 0.05;
  const double rows[5][5] = {// m1, m2, v1, v2, e
                             {1, 3, 1.5, -0.5, 0.6},
                             {0.0137, 0.0137, 0.5, -0.5, 0.3},
                             {1, 0.01, 1, 0, 0.5},
                             {0.01, 1, 2, 0, 0.9},
                             {2, 1, 1, 0.2, 0.1}};
  for (const auto& [m1, m2, v1, v2, nominal] : rows) {
    const double k1 = 2e5, k2 = 3e5, stiffness = k1 * k2 / (k1 + k2);
    const double e = restitution_with_floor(nominal), reduced = m1 * m2 / (m1 + m2);
    Model model = scenes::empty(scenes::law(0, nominal), scenes::law(0, nominal));
    scenes::add_particles(model, scenes::add_shape(model, sphere(radius, m1, k1)));
    scenes::add_particles(model, scenes::add_shape(model, sphere(radius, m2, k2)));
    model.gravity.setZero();
    model.timestep = quarter_period(reduced, stiffness) * nominal / 400;
    Solver solver(model);
    const double gap = 0.3 * (v1 - v2) * model.timestep;
    solver.insert(0, {-radius, 0, 0}, Quat::Identity(), {v1, 0, 0}, Vec3::Zero());
    solver.insert(1, {radius + gap, 0, 0}, Quat::Identity(), {v2, 0, 0}, Vec3::Zero());
    const double plain = (1 + nominal) * quarter_period(reduced, stiffness);
    scenes::run(solver, 1.5 * lengthening(nominal, 0.001) * plain);
    const ParticleState& p = solver.particles();
    const double center = (m1 * v1 + m2 * v2) / (m1 + m2), relative = v1 - v2;
    const std::string scene =
        fmt::format("m {} and {} kg, v {} and {} m/s, e = {}: ", m1, m2, v1, v2, nominal);
    checks.push_back({scene + "first speed after", p.velocity[0].x(),
                      center - m2 / (m1 + m2) * e * relative, 2e-3 * relative, Bound::absolute,
                      "m/s"});
    checks.push_back({scene + "second speed after", p.velocity[1].x(),
                      center + m1 / (m1 + m2) * e * relative, 2e-3 * relative, Bound::absolute,
                      "m/s"});
    checks.push_back({scene + "momentum", m1 * p.velocity[0].x() + m2 * p.velocity[1].x(),
                      m1 * v1 + m2 * v2, 1e-12 * (m1 + m2), Bound::absolute, "kg m/s"});
    checks.push_back({scene + "largest force", p.peak_normal_force[0],
                      relative * std::sqrt(reduced * stiffness), 2e-4, Bound::relative, "N"});
    const double loss = 0.5 * reduced * relative * relative * (1 - e * e);
    checks.push_back({scene + "energy lost", solver.energy().dissipated_normal, loss, 2e-3,
                      Bound::relative, "J"});
  }
  return checks;
}

// An apex of h gives the next one of e^2 h, and a little less: gravity also works along the dent
// s = v sqrt(m / K) and the sphere climbs out of it, e^2 (h + s) - s.
std::vector<Check> bouncing() {
  std::vector<Check> checks;
  const double radius = 0.05, height = 0.5, stiffness = 1e7;
  for (const double nominal : {0.5, 0.7}) {
    const double e = restitution_with_floor(nominal);
    Model model = scenes::body_on_plane(sphere(radius, 1, stiffness), scenes::law(0, nominal));
    model.timestep = quarter_period(1, stiffness) * nominal / 50;
    Solver solver(model);
    solver.insert(0, {0, 0, radius + height}, Quat::Identity(), Vec3::Zero(), Vec3::Zero());
    std::vector<double> apexes;
    double before = 0;
    while (apexes.size() < 4 && solver.time() < 3) {
      solver.step();
      const double now = solver.particles().velocity[0].z();
      if (before > 0 && now <= 0) apexes.push_back(solver.particles().position[0].z() - radius);
      before = now;
    }
    double expected = height;
    for (std::size_t k = 0; k < apexes.size(); ++k) {
      const double dent = std::sqrt(2 * kGravity * expected / stiffness);
      expected = e * e * (expected + dent) - dent;
      checks.push_back({fmt::format("e = {}: height of apex {}", nominal, k + 1), apexes[k],
                        expected, 5e-3, Bound::relative, "m"});
    }
  }
  return checks;
}

// A sphere between a rigid floor and a rigid lid that moves so slowly that inertia does not count.
// The two contacts are alike: each has half the lid's way as overlap, so the pair is a spring of
// K/2 with K_u/2 on the way back.
std::vector<Check> slow_squeeze() {
  const double radius = 0.05, stiffness = 1e5, e = 0.5, rate = 0.01;
  const double unloading = stiffness / (e * e);
  // The lid goes down to 1 mm, back by 0.1 mm, down again to 1 mm and on to 1.5 mm.
  const std::array<double, 4> legs = {1e-3, -0.1e-3, 0.1e-3, 0.5e-3};
  Model model = scenes::body_on_plane(sphere(radius, 0.001, stiffness), scenes::law(0, e));
  model.gravity.setZero();
  const int lid = scenes::add_plane(model, {0, 0, 2 * radius}, -Vec3::UnitZ());
  double start = 0;
  for (const double leg : legs) {
    Motion m;
    m.velocity = {0, 0, leg > 0 ? -rate : rate};
    m.start = start;
    m.stop = start += std::abs(leg) / rate;
    model.boundaries[lid].motions.push_back(m);
  }
  model.timestep = quarter_period(0.001, stiffness) * e / 10;
  Solver solver(model);
  solver.insert(0, {0, 0, radius}, Quat::Identity(), Vec3::Zero(), Vec3::Zero());
  std::vector<Check> checks;
  double time = 0;
  const char* names[4] = {"loaded to 1 mm", "unloaded by 0.1 mm", "loaded again to 1 mm",
                          "loaded on to 1.5 mm"};
  const double forces[4] = {stiffness * 0.5e-3, stiffness * 0.5e-3 - unloading * 0.05e-3,
                            stiffness * 0.5e-3, stiffness * 0.75e-3};
  std::array<double, 4> work{};  // J, by the lid up to the end of each leg
  for (std::size_t k = 0; k < legs.size(); ++k) {
    // The mean force over the last hundredth of each leg, whose middle is half a hundredth before.
    const double leg = std::abs(legs[k]) / rate;
    scenes::run(solver, time + 0.99 * leg - solver.time());
    solver.clear_boundary_loads();
    const double from = solver.time();
    scenes::run(solver, 0.01 * leg);
    time += leg;
    const double mean = solver.boundaries()[lid].impulse.z() / (solver.time() - from);
    const double slope = k == 0 || k == 3 ? stiffness : unloading;
    const double expected = forces[k] - 0.005 * 0.5 * legs[k] * slope;
    checks.push_back({fmt::format("force on the lid, {}", names[k]), mean, expected, 3e-3,
                      Bound::relative, "N"});
    work[k] = solver.energy().boundary_work;
  }
  checks.push_back(
      {"work of loading to 1 mm", work[0], 0.25 * stiffness * 1e-6, 5e-3, Bound::relative, "J"});
  checks.push_back({"lost by unloading and loading again, of that work",
                    (work[2] - work[0]) / work[0], 0, 2e-3, Bound::absolute, "1"});
  return checks;
}

}  // namespace

std::vector<VerificationCase> impact_cases() {
  const std::string wall = "Sphere on a rigid wall";
  std::vector<VerificationCase> cases = {
      {"impact.normal", wall + ": a sweep over speed, mass, stiffness and restitution",
       "v sqrt(m/K), v sqrt(m K), (1 + e) pi/2 sqrt(m/K), (1 - e^2) s_max, m v^2 (1 - e'^2)/2",
       "200 steps a quarter period of unloading. Times and the residual overlap are read to a "
       "step, "
       "about 0.5 %. Restitution and loss do not depend on speed, mass or stiffness. e' is the "
       "restitution with the unloading floor.",
       Tier::quick, normal_impact},
      {"impact.published", wall + ": two published rows",
       "the same closed forms, as numbers worked out by others",
       "The floor's small share is taken off where the published value has none.", Tier::quick,
       published_impacts},
      {"impact.floor", "What the unloading floor lambda does",
       "e'^2 = 1 - r (1 - lambda), r = (1 - e^2) / (1 - lambda e^2); time of overlap from three "
       "springs in turn",
       "lambda = 0.001, the default, raises e = 0.3 to 0.3014, and the overlap lasts 2.5 times as "
       "long as that of a spring without a floor (e = 0.1: 6.5 times).",
       Tier::quick, unloading_floor},
      {"impact.time_step", wall + ": the error of the restitution against the time step",
       "the closed form; the order at which the error falls",
       "The default step has 10 steps a quarter period of the stiffest spring.", Tier::quick,
       time_step},
      {"impact.two_bodies", "Two spheres of different mass and stiffness",
       "momentum and restitution; F = v sqrt(m* K), 1/m* = 1/m1 + 1/m2, 1/K = 1/K1 + 1/K2", "",
       Tier::quick, two_bodies},
      {"impact.bouncing", "A bouncing sphere's apexes",
       "h' = e'^2 (h + s) - s, with the dent s = sqrt(2 g h m / K)", "", Tier::quick, bouncing},
      {"impact.squeeze", "A sphere squeezed slowly: loading, unloading, loading again",
       "two springs K in series on the way in, K / e^2 on the way back and in again",
       "Below the largest overlap so far nothing is lost.", Tier::quick, slow_squeeze}};
  for (auto* more : {impact_floor_cases, oblique_cases}) {
    for (VerificationCase& c : more()) cases.push_back(std::move(c));
  }
  return cases;
}

}  // namespace firn::verification
