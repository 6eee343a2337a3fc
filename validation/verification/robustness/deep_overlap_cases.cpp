// Deep overlaps, wedged bodies, and long rest.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "validation/verification/fixtures/check.h"
#include "validation/verification/fixtures/wall_impact.h"
#include "validation/verification/robustness/robustness_cases.h"

namespace firn::verification {
namespace {

using scenes::kGravity;

// e'^2 of the hysteretic spring with the unloading floor lambda: the part of the work that comes
// back (see impact.floor).
double returned_part(double e, double lambda = 0.001) {
  const double r = (1 - e * e) / (1 - lambda * e * e);
  return 1 - r * (1 - lambda);
}

Shape cube(double edge) { return make_box(Vec3::Constant(edge), scenes::ice_options(0, 0, 1e-3)); }

Motion translation(const Vec3& velocity, double start, double stop) {
  Motion m;
  m.velocity = velocity;
  m.start = start;
  m.stop = stop;
  return m;
}

// --- A platen comes down on a body on the floor, and goes back up. -------------------------------

struct Crush {
  double put_in = 0;    // J, the most that the platen gave
  double returned = 0;  // J, that it got back
  double rise = 0;      // J, of all energy less what the platen gave, above that at the start
  double overlap = 0;   // m
  bool failed = false;
};

Crush crush(const Shape& shape, double height, double depth, double platen_thickness, double e) {
  constexpr double speed = 0.1;
  Model model = scenes::body_on_plane(shape, scenes::law(0, e));
  model.gravity.setZero();
  Boundary platen = sheet({.kind = ThinWall::Kind::box, .thickness = platen_thickness});
  platen.origin = Vec3(0, 0, height + platen_thickness / 2);
  const double turn = depth / speed;
  platen.motions = {translation({0, 0, -speed}, 0, turn), translation({0, 0, speed}, turn, 9)};
  model.boundaries.push_back(platen);
  model.timestep = advise_timestep(model, 10).timestep;
  Solver solver(model);
  solver.insert(0, {0, 0, height / 2}, Quat::Identity(), Vec3::Zero(), Vec3::Zero());
  Crush out;
  try {
    while (solver.time() < 2.2 * turn) {
      scenes::run(solver, 10 * model.timestep);
      const Energy now = solver.energy();
      out.put_in = std::max(out.put_in, now.boundary_work);
      out.rise = std::max(out.rise, scenes::mechanical(now) - now.boundary_work);
    }
  } catch (const RunError&) {
    out.failed = true;
    return out;
  }
  out.returned = out.put_in - solver.energy().boundary_work;
  out.overlap = solver.diagnostics().largest_overlap;
  return out;
}

std::vector<Check> crushing() {
  std::vector<Check> checks;
  const Shape box = cube(20e-3), ball = make_sphere(10e-3, scenes::ice_options(0, 0, 0));
  for (const auto& [name, shape] : {std::pair{"cube", &box}, {"sphere", &ball}}) {
    for (const double depth : {4e-3, 8e-3, 16e-3}) {
      for (const double thickness : {0.5e-3, 20e-3}) {
        for (const double e : {0.3, 0.8}) {
          const Crush got = crush(*shape, 20e-3, depth, thickness, e);
          const std::string what =
              fmt::format("{} pressed by {:g} mm, platen {:g} mm, e = {:g}: ", name, depth * 1e3,
                          thickness * 1e3, e);
          // Two springs in series, the floor's and the platen's.
          const double work = 0.25 * shape->stiffness * depth * depth;
          checks.push_back({.what = what + "work put in",
                            .measured = got.put_in,
                            .expected = work,
                            .tolerance = 0.01,
                            .unit = "J"});
          checks.push_back({.what = what + "work returned",
                            .measured = got.returned,
                            .expected = returned_part(e) * work,
                            .tolerance = 0.01 * work,
                            .bound = Bound::absolute,
                            .unit = "J"});
          checks.push_back({.what = what + "energy beyond what the platen gave",
                            .measured = got.rise,
                            .expected = 1e-3 * work,
                            .bound = Bound::at_most,
                            .unit = "J"});
        }
      }
    }
    checks.push_back({.what = fmt::format("{} pressed by 22 mm, beyond the limit: stopped", name),
                      .measured = double(crush(*shape, 20e-3, 22e-3, 0.5e-3, 0.3).failed),
                      .expected = 1,
                      .bound = Bound::at_least});
  }
  return checks;
}

// --- Bodies placed into something. ---------------------------------------------------------------

std::vector<Check> initial_overlap_case() {
  std::vector<Check> checks;
  constexpr double edge = 20e-3, e = 0.5;
  const Shape box = cube(edge);
  int stopped = 0, wanted = 0;
  for (const double part : {0.001, 0.01, 0.04, 0.06, 0.1, 0.3, 0.6, 0.9}) {
    for (ThinWall wall :
         {ThinWall{.kind = ThinWall::Kind::plane}, ThinWall{.kind = ThinWall::Kind::box},
          ThinWall{.kind = ThinWall::Kind::mesh, .cells = 15}}) {
      Model model = scenes::body_on_plane(box, scenes::law(0, e));
      model.boundaries = {sheet(wall)};
      model.gravity.setZero();
      model.timestep = advise_timestep(model, 50).timestep;
      Solver solver(model);
      const double depth = part * edge;
      solver.insert(0, {0, 0, edge / 2 - depth}, Quat::Identity(), Vec3::Zero(), Vec3::Zero());
      bool failed = false;
      try {
        scenes::run(solver, 5e-3);
      } catch (const RunError&) {
        failed = true;
      }
      if (part > 0.05) {
        ++wanted;
        stopped += failed;
        continue;
      }
      checks.push_back({.what = fmt::format("placed {:g} mm deep, wall {} cells: energy on leaving",
                                            depth * 1e3, wall.cells),
                        .measured = failed ? std::nan("") : solver.energy().kinetic,
                        .expected = returned_part(e) * 0.5 * box.stiffness * depth * depth,
                        .tolerance = 0.02,
                        .unit = "J"});
    }
    // Into another body.
    Model model = scenes::empty(scenes::law(0, e), scenes::law(0, e));
    scenes::add_particles(model, scenes::add_shape(model, box), 2);
    model.gravity.setZero();
    model.timestep = advise_timestep(model, 50).timestep;
    Solver solver(model);
    solver.insert(0, Vec3::Zero(), Quat::Identity(), Vec3::Zero(), Vec3::Zero());
    solver.insert(1, {0, 0, edge * (1 - part)}, Quat::Identity(), Vec3::Zero(), Vec3::Zero());
    bool failed = false;
    try {
      scenes::run(solver, 5e-3);
    } catch (const RunError&) {
      failed = true;
    }
    wanted += part > 0.05;
    stopped += part > 0.05 && failed;
  }
  checks.push_back({.what = "placed deeper than a twentieth of the edge: runs stopped",
                    .measured = double(stopped),
                    .expected = double(wanted),
                    .bound = Bound::at_least});
  return checks;
}

// --- A cube wedged between a blade and a wall. ---------------------------------------------------

// A blade that leans over the cube by an angle and comes from the left, until it has squeezed the
// cube against the wall.
struct Wedge {
  static constexpr double edge = 20e-3, push = 0.05;  // m, m/s
  double squeeze = 0, degrees = 0;                    // m, of the cube
  double stop() const {                               // s, when the blade is there
    return (squeeze + 0.1e-3 / std::cos(degrees * kDegToRad)) / push;
  }
};

Boundary blade_of(const Wedge& w) {
  Boundary blade;
  blade.name = "blade";
  blade.material = scenes::kPlastic;
  blade.rigid = true;
  blade.kind = Boundary::Kind::solid;
  std::vector<HalfSpace> sides;
  for (int axis = 0; axis < 3; ++axis) {
    const double half = axis == 0 ? 1e-3 : 30e-3;
    for (const double sign : {-1.0, 1.0}) sides.push_back({sign * Vec3::Unit(axis), half});
  }
  blade.parts = {convex_part(sides, 0)};
  blade.orientation = Quat(Eigen::AngleAxisd(w.degrees * kDegToRad, Vec3::UnitY()));
  // Its face just touches the cube's upper left edge (leaning) or left face.
  blade.origin =
      Vec3(-Wedge::edge / 2, 0, Wedge::edge) - blade.orientation * Vec3(1e-3 + 0.1e-3, 0, 0);
  blade.motions = {translation({Wedge::push, 0, 0}, 0, w.stop())};
  return blade;
}

std::vector<Check> wedge_checks(const Wedge& w) {
  constexpr double edge = Wedge::edge, push = Wedge::push;
  Model model = scenes::body_on_plane(cube(edge), scenes::law(0.3, 0.3));
  const double dt = model.timestep = advise_timestep(model, 10).timestep;
  scenes::add_plane(model, {edge / 2, 0, 0}, -Vec3::UnitX());
  model.boundaries.push_back(blade_of(w));
  Solver solver(model);
  solver.insert(0, {0, 0, edge / 2 + 1e-6}, Quat::Identity(), Vec3::Zero(), Vec3::Zero());
  scenes::run(solver, w.stop() + 0.1);
  const Vec3 before = solver.particles().velocity[0];
  const double peak = solver.particles().peak_normal_force[0];
  double wall_peak = 0;
  for (const BoundaryState& b : solver.boundaries())
    wall_peak = std::max(wall_peak, b.peak_normal_force);
  solver.clear_boundary_loads();
  constexpr double hold = 0.05;
  const double mass = model.shapes[0].mass, begin = solver.time();
  scenes::run(solver, hold);
  const double took = solver.time() - begin;
  Vec3 impulse = Vec3::Zero();
  double largest = 0;
  for (const BoundaryState& b : solver.boundaries()) {
    impulse += b.impulse;
    largest = std::max(largest, b.impulse.norm() / took);
  }
  const Vec3 change = mass * (solver.particles().velocity[0] - before);
  const Vec3 missing = change + impulse - mass * took * model.gravity;
  const std::string what =
      fmt::format("blade at {:g} degrees, {:g} mm: ", w.degrees, w.squeeze * 1e3);
  std::vector<Check> checks;
  // Impulses are sums over whole steps, kicks go by halves: half a step's force at each end.
  checks.push_back({.what = what + "momentum that no force explains",
                    .measured = missing.norm(),
                    .expected = 0,
                    .tolerance = dt * std::max(largest, mass * kGravity),
                    .bound = Bound::absolute,
                    .unit = "N s"});
  checks.push_back({.what = what + "peak of the cube over that of the walls",
                    .measured = peak / wall_peak,
                    .expected = 1,
                    .tolerance = 1e-12});
  checks.push_back({.what = what + "kinetic energy left",
                    .measured = solver.energy().kinetic,
                    .expected = 0.5 * mass * push * push,
                    .bound = Bound::at_most,
                    .unit = "J"});
  if (w.degrees > 0) return checks;
  // Two springs in series: blade and wall.
  const double force = 0.5 * model.shapes[0].stiffness * w.squeeze;
  checks.push_back({.what = what + "squeezing force",
                    .measured = peak,
                    .expected = force,
                    .tolerance = 0.02,
                    .unit = "N"});
  return checks;
}

std::vector<Check> wedge_case() {
  std::vector<Check> checks;
  for (const double squeeze : {1e-3, 3e-3, 6e-3})
    for (const double degrees : {0.0, 10.0, 25.0})
      for (Check& check : wedge_checks({.squeeze = squeeze, .degrees = degrees}))
        checks.push_back(std::move(check));
  return checks;
}

// --- Rest. ---------------------------------------------------------------------------------------

std::vector<Check> incline() {
  std::vector<Check> checks;
  const Shape block = cube(20e-3), crescent = scenes::crescent();
  for (const auto& [name, shape] : {std::pair{"cube", &block}, {"crescent", &crescent}}) {
    for (const auto& [degrees, friction] : {std::pair{5.0, 0.1}, {15.0, 0.3}, {20.0, 0.5}}) {
      Model model = scenes::body_on_plane(*shape, scenes::law(friction, 0.3));
      model.gravity =
          kGravity * Vec3(std::sin(degrees * kDegToRad), 0, -std::cos(degrees * kDegToRad));
      model.timestep = 1e-5;
      Solver solver(model);
      // The crescent lies on its flat rim, upside down.
      const bool upside_down = shape == &crescent;
      const Quat turn =
          upside_down ? Quat(Eigen::AngleAxisd(std::numbers::pi, Vec3::UnitX())) : Quat::Identity();
      // A crescent stands on both ends of its rim, each with the full stiffness.
      const double stiffness = (upside_down ? 2 : 1) * shape->stiffness;
      const double dent = shape->mass * kGravity * std::cos(degrees * kDegToRad) / stiffness;
      solver.insert(0, {0, 0, -lowest_point(*shape, turn) - dent}, turn, Vec3::Zero(),
                    Vec3::Zero());
      scenes::run(solver, 0.5);
      const Vec3 place = solver.particles().position[0];
      scenes::run(solver, 1);
      const std::string what =
          fmt::format("{}, {:g} degrees, mu = {:g}, 100000 steps: ", name, degrees, friction);
      checks.push_back({.what = what + "creep",
                        .measured = (solver.particles().position[0] - place).norm(),
                        .expected = 1e-6,
                        .bound = Bound::at_most,
                        .unit = "m"});
      checks.push_back({.what = what + "kinetic energy over m g 1 um",
                        .measured = solver.energy().kinetic / (shape->mass * kGravity * 1e-6),
                        .expected = 1e-3,
                        .bound = Bound::at_most});
    }
  }
  return checks;
}

struct SettledHeap {
  int bodies = 0, creeping = 0;  // farther than 10 um in a second
  double farthest = 0;           // m
  double kinetic = 0, rise = 0;  // of m g 1 um of all at the end; of the height energy
};

void rest(std::uint64_t seed, SettledHeap& out) {
  constexpr int kBodies = 24;
  Model model = scenes::empty(scenes::law(0.1, 0.3), scenes::law(0.3, 0.3));
  scenes::add_particles(model, scenes::add_shape(model, scenes::crescent()), kBodies);
  scenes::add_box_of_planes(model, Vec3::Zero(), {0.14, 0.12, 0});
  model.timestep = 1e-5;
  Solver solver(model);
  scenes::scatter(solver, 0, kBodies, Vec3::Zero(), {0.14, 0.12, 0.3}, seed);
  scenes::run(solver, 1.5);
  const std::vector<Vec3> places = solver.particles().position;
  const double height = solver.energy().gravitational;
  scenes::run(solver, 1);
  for (int i = 0; i < kBodies; ++i) {
    const double moved = (solver.particles().position[i] - places[i]).norm();
    out.farthest = std::max(out.farthest, moved);
    out.creeping += moved > 1e-5;
  }
  out.bodies += kBodies;
  const Energy e = solver.energy();
  out.kinetic =
      std::max(out.kinetic, e.kinetic / (kBodies * model.shapes[0].mass * kGravity * 1e-6));
  out.rise = std::max(out.rise, (e.gravitational - height) / height);
}

std::vector<Check> pile() {
  SettledHeap r;
  for (std::uint64_t seed = 3; seed < 6; ++seed) rest(seed, r);
  return {{.what = fmt::format("bodies that creep by more than 10 um in 1 s, of {} in 3 piles",
                               r.bodies),
           .measured = static_cast<double>(r.creeping),
           .expected = 0.05 * r.bodies,
           .bound = Bound::at_most},
          {.what = "farthest way of a body in 1 s, 100000 steps",
           .measured = r.farthest,
           .expected = 0.3e-3,
           .bound = Bound::at_most,
           .unit = "m"},
          {.what = "largest kinetic energy at the end over m g 1 um of all",
           .measured = r.kinetic,
           .expected = 1e-2,
           .bound = Bound::at_most},
          {.what = "largest rise of the height energy, relative",
           .measured = r.rise,
           .expected = 1e-6,
           .bound = Bound::at_most}};
}

}  // namespace

std::vector<VerificationCase> deep_cases() {
  return {
      {.name = "robustness.crushing",
       .title = "A platen presses a body deep into floor and platen, and goes back",
       .reference = "two springs in series: work K d^2 / 4; the part e'^2 of it comes back, "
                    "e'^2 = 1 - r (1 - lambda), r = (1 - e^2) / (1 - lambda e^2)",
       .remark = "To 80 % of the body's height, each contact 40 %. The platen moves at 0.1 m/s; "
                 "the swing that this starts, m v^2 / 2, is below 1e-3 of the work: tolerance "
                 "1 %. Deeper than half of the smallest edge a contact stops the run.",
       .tier = Tier::quick,
       .run = crushing},
      {.name = "robustness.placed_inside",
       .title = "Bodies placed into walls and bodies",
       .reference = "up to a twentieth of the smallest edge the spring, tight from the start, "
                    "returns e'^2 K d^2 / 2; deeper the run stops at its first step",
       .remark = "Tolerance 2 %: the step at which a point is found takes its overlap as it is.",
       .tier = Tier::quick,
       .run = initial_overlap_case},
      {.name = "robustness.wedged",
       .title = "A cube wedged between a blade, a wall and the floor",
       .reference = "m dv = (m g - sum of the forces on the walls) dt; peaks of both bodies of a "
                    "contact alike; upright blade: force K d / 2",
       .remark = "Momentum to one step's force: impulses count whole steps, kicks half steps at "
                 "both ends. The force of the upright blade to 2 %: friction carries a little. "
                 "What still swings may hold what the blade's speed gave, m v^2 / 2: the law "
                 "damps no swing below the largest load.",
       .tier = Tier::quick,
       .run = wedge_case},
      {.name = "robustness.incline",
       .title = "100 000 steps at rest on an incline below the angle of friction",
       .reference = "creep below 1 um in 1 s; the block does not warm up",
       .remark = "Set down in its own dent, after 0.5 s to settle. Creep below 1 um; energy below "
                 "a thousandth of what a fall of 1 um gives. A block that is dropped keeps "
                 "swinging by some m g / K, which the law does not damp, and each time the "
                 "floor unloads friction lets go of it: such a one creeps.",
       .tier = Tier::quick,
       .run = incline},
      {.name = "robustness.pile",
       .title = "100 000 steps of a settled pile of crescents",
       .reference = "a pile at rest stays as it is",
       .remark = "24 crescents in a box, 1.5 s to settle. Hysteretic contacts may still give way "
                 "by micrometers: 10 um in 1 s.",
       .tier = Tier::full,
       .run = pile}};
}

}  // namespace firn::verification
