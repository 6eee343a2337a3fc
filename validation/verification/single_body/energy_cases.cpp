// Energy of impacts without friction: random bodies that hit planes, meshes and each other.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

#include "validation/verification/fixtures/check.h"
#include "validation/verification/fixtures/wall_impact.h"
#include "validation/verification/single_body/cases.h"

namespace firn::verification {
namespace {

constexpr double kSpeed = 1.4;      // m/s
constexpr double kSteps = 50;       // in a quarter period of the stiffest contact
constexpr double kMass = 0.0137;    // kg
constexpr double kStiffness = 6e5;  // N/m
constexpr double kLeastGood = 0.9;  // part of the impacts within 0.2 %
constexpr double kLeastKept = 0.97, kMostKept = 1.02;  // of the energy, any impact

enum class Target { plane, mesh, each_other, nested };

struct Family {
  std::string name;
  std::function<Shape(scenes::Random&)> shape;
  Target target = Target::plane;
  double tilt = -1;  // rad, most, from the posture as drawn; below 0: any orientation
};

Shape random_hull(scenes::Random& random) {
  std::vector<Vec3> corners;
  for (int i = 0; i < 8; ++i) {
    Vec3 x;
    for (int axis = 0; axis < 3; ++axis) x[axis] = random.uniform(-14e-3, 14e-3);
    corners.push_back(x);
  }
  return make_convex(corners, scenes::ice_options(kMass, kStiffness, -1));
}

std::function<Shape(scenes::Random&)> box(const Vec3& size) {
  return [size](scenes::Random&) {
    return make_box(size, scenes::ice_options(kMass, kStiffness, -1));
  };
}

std::function<Shape(scenes::Random&)> crescent(double dish) {
  return [dish](scenes::Random&) {
    CrescentParameters p = named_crescent("mass-matched", {}).parameters;
    p.top_concavity_depth = dish;
    return make_crescent(p, scenes::ice_options(kMass, kStiffness, 1e-3));
  };
}

std::function<Shape(scenes::Random&)> any_sphere() {
  return [](scenes::Random&) {
    return make_sphere(10e-3, scenes::ice_options(kMass, kStiffness, -1));
  };
}

std::vector<Family> families() {
  const Vec3 cube(22e-3, 22e-3, 22e-3), brick(30e-3, 20e-3, 12e-3);
  constexpr double flat = 4 * kDegToRad;
  return {{"sphere on a plane", any_sphere()},
          {"cube on a plane", box(cube)},
          {"box on a plane", box(brick)},
          {"random hull on a plane", random_hull},
          {"crescent on a plane", crescent(1e-3)},
          {"cube near flat on a plane", box(cube), Target::plane, flat},
          {"box near flat on a plane", box(brick), Target::plane, flat},
          {"crescent near flat on a plane", crescent(1e-3), Target::plane, flat},
          {"cube on a mesh", box(cube), Target::mesh},
          {"crescent on a mesh", crescent(1e-3), Target::mesh},
          {"two spheres", any_sphere(), Target::each_other},
          {"two cubes", box(cube), Target::each_other},
          {"two random hulls", random_hull, Target::each_other},
          {"two crescents", crescent(1e-3), Target::each_other},
          {"two crescents with a dish of 4 mm", crescent(4e-3), Target::each_other},
          {"back of a crescent in the dish of another", crescent(1e-3), Target::nested},
          {"back of a crescent in a dish of 4 mm", crescent(4e-3), Target::nested}};
}

Vec3 random_direction(scenes::Random& random) { return random.orientation() * Vec3::UnitX(); }

// A rotation by at most `most` (rad) about any axis.
Quat small_turn(scenes::Random& random, double most) {
  return Quat(Eigen::AngleAxisd(most * std::sqrt(random.uniform(0, 1)), random_direction(random)));
}

// Kinetic energy after an elastic impact over that before; nothing if the bodies miss each other.
std::optional<double> kept_energy(const Family& family, double steps, std::uint64_t seed) {
  scenes::Random random(seed);
  Model model = scenes::empty(scenes::law(0, 1), scenes::law(0, 1));
  const Shape shape = family.shape(random);
  const double reach = shape.bounding_radius;
  const bool pair = family.target == Target::each_other || family.target == Target::nested;
  scenes::add_particles(model, scenes::add_shape(model, shape), pair ? 2 : 1);
  if (family.target == Target::plane) scenes::add_plane(model, Vec3::Zero(), Vec3::UnitZ());
  if (family.target == Target::mesh)
    model.boundaries.push_back(
        sheet({.kind = ThinWall::Kind::mesh, .thickness = 5e-3, .cells = 12}));
  model.gravity.setZero();
  model.timestep = advise_timestep(model, steps).timestep;
  Solver solver(model);
  const Quat turn = family.tilt >= 0 ? small_turn(random, family.tilt) : random.orientation();
  const double spread = family.target == Target::each_other ? 0.6 : 0.15;
  const Vec3 aside(random.uniform(-spread, spread) * reach, random.uniform(-spread, spread) * reach,
                   0);
  const double far = (pair ? 2 : 1) * reach + 1e-3;
  const Vec3 velocity(0, 0, pair ? -kSpeed / 2 : -kSpeed);
  if (family.target == Target::nested) {
    solver.insert(0, Vec3(0, 0, far) + aside, small_turn(random, 0.25), velocity, Vec3::Zero());
    solver.insert(1, Vec3::Zero(), Quat::Identity(), -velocity, Vec3::Zero());
  } else {
    solver.insert(0, Vec3(0, 0, far) + aside, turn, velocity, Vec3::Zero());
    if (pair) solver.insert(1, Vec3::Zero(), random.orientation(), -velocity, Vec3::Zero());
  }
  const double before = solver.energy().kinetic;
  bool touched = false;
  while (solver.time() < 40 * far / kSpeed) {
    solver.step();
    touched |= solver.diagnostics().largest_overlap > 0;
    const ParticleState& p = solver.particles();
    const Vec3 apart = pair ? Vec3(p.position[0] - p.position[1]) : Vec3(0, 0, p.position[0].z());
    const Vec3 speed = pair ? Vec3(p.velocity[0] - p.velocity[1]) : p.velocity[0];
    if (apart.norm() > 1.001 * far && speed.dot(apart) > 0) break;
  }
  if (!touched) return std::nullopt;
  return solver.energy().kinetic / before;
}

std::vector<Check> elastic_impacts(int count) {
  constexpr double kWithin = 2e-3;
  std::vector<Check> checks;
  for (const Family& family : families()) {
    double lowest = 1, highest = 1;
    int hits = 0, good = 0;
    for (int i = 0; i < count; ++i) {
      const std::optional<double> kept = kept_energy(family, kSteps, 1000 + i);
      if (!kept) continue;
      ++hits;
      good += std::abs(*kept - 1) <= kWithin;
      lowest = std::min(lowest, *kept);
      highest = std::max(highest, *kept);
    }
    const std::string what = fmt::format("{}, {} impacts: ", family.name, hits);
    checks.push_back({.what = what + "part that keeps its energy within 0.2 %",
                      .measured = static_cast<double>(good) / hits,
                      .expected = kLeastGood,
                      .bound = Bound::at_least});
    checks.push_back({.what = what + "least energy kept",
                      .measured = lowest,
                      .expected = kLeastKept,
                      .bound = Bound::at_least});
    checks.push_back({.what = what + "most energy kept",
                      .measured = highest,
                      .expected = kMostKept,
                      .bound = Bound::at_most});
  }
  return checks;
}

// The scatter of the kept energy as the time step shrinks.
std::vector<Check> elastic_convergence() {
  constexpr int kCount = 40;
  const std::vector<Family> all = families();
  std::vector<Check> checks;
  for (const char* name : {"cube on a plane", "two crescents"}) {
    const auto family = std::ranges::find(all, name, &Family::name);
    double errors[3];
    const double steps[3] = {10, 20, 40};
    for (int k = 0; k < 3; ++k) {
      double sum = 0;
      int hits = 0;
      for (int i = 0; i < kCount; ++i) {
        const std::optional<double> kept = kept_energy(*family, steps[k], 1000 + i);
        if (!kept) continue;
        ++hits;
        sum += (*kept - 1) * (*kept - 1);
      }
      errors[k] = std::sqrt(sum / hits);
    }
    for (int k = 1; k < 3; ++k) {
      checks.push_back({.what = fmt::format("{}: rms error of the energy, {:g} steps in a quarter "
                                            "period over {:g}",
                                            name, steps[k], steps[k - 1]),
                        .measured = errors[k] / errors[k - 1],
                        .expected = 0.6,
                        .bound = Bound::at_most});
    }
  }
  return checks;
}

// Bodies that fly about in a closed box, without gravity.
double kept_in_box(const Shape& shape, double edge, double time) {
  constexpr int kBodies = 27;
  Model model = scenes::empty(scenes::law(0, 1), scenes::law(0, 1));
  scenes::add_particles(model, scenes::add_shape(model, shape), kBodies);
  scenes::add_box_of_planes(model, Vec3::Zero(), Vec3::Constant(edge));
  scenes::add_plane(model, {0, 0, edge}, -Vec3::UnitZ(), false);
  model.gravity.setZero();
  model.timestep = advise_timestep(model, kSteps).timestep;
  Solver solver(model);
  scenes::Random random(5);
  for (int particle = 0; particle < kBodies;) {
    Vec3 place;
    for (int axis = 0; axis < 3; ++axis) place[axis] = random.uniform(0, edge);
    const Quat turn = random.orientation();
    if (solver.overlaps(0, place, turn, 0.5e-3)) continue;
    solver.insert(particle++, place, turn, kSpeed * random_direction(random), Vec3::Zero());
  }
  const double before = solver.energy().kinetic;
  scenes::run(solver, time);
  const Energy energy = solver.energy();
  return (energy.kinetic + energy.elastic) / before;
}

std::vector<Check> elastic_box() {
  const ShapeOptions options = scenes::ice_options(kMass, kStiffness, 1e-3);
  std::vector<Check> checks;
  const auto add = [&](const std::string& what, double kept, double tolerance) {
    checks.push_back({.what = what,
                      .measured = kept,
                      .expected = 1,
                      .tolerance = tolerance,
                      .bound = Bound::absolute});
  };
  add("27 spheres, energy kept", kept_in_box(make_sphere(10e-3, options), 0.1, 0.5), 5e-4);
  add("27 cubes, energy kept", kept_in_box(make_box(Vec3::Constant(22e-3), options), 0.16, 0.5),
      2e-3);
  add("27 crescents, energy kept", kept_in_box(scenes::crescent(), 0.22, 0.5), 2e-3);
  return checks;
}

// A cube that is tilted about one edge hits with that edge first, then with the opposite one. Each
// impact has the restitution e. Energies and velocities over those before the first impact; edge 1.
double two_edge_impacts(double e) {
  constexpr double kArm = 0.5, kInertia = 1.0 / 6;
  const double effective = 1 / (1 + kArm * kArm / kInertia);
  double down = 1, omega = 0;
  const double first = effective * (1 + e) * down;
  down -= first;
  omega += first * kArm / kInertia;
  const double second = effective * (1 + e) * (down + kArm * omega);
  down -= second;
  omega -= second * kArm / kInertia;
  return down * down + kInertia * omega * omega;
}

std::vector<Check> near_flat_impacts() {
  constexpr int kCount = 40;
  std::vector<Check> checks;
  for (const double e : {0.3, 0.5}) {
    double lowest = 1, highest = 0;
    for (int i = 0; i < kCount; ++i) {
      scenes::Random random(2000 + i);
      const double tilt = 4 * kDegToRad * random.uniform(0, 1);
      Model model = scenes::body_on_plane(
          make_box(Vec3::Constant(22e-3), scenes::ice_options(kMass, kStiffness, -1)),
          scenes::law(0, e));
      model.gravity.setZero();
      model.timestep = advise_timestep(model, kSteps).timestep;
      Solver solver(model);
      solver.insert(0, {0, 0, 20e-3}, Quat(Eigen::AngleAxisd(tilt, Vec3::UnitX())), {0, 0, -kSpeed},
                    Vec3::Zero());
      const double before = solver.energy().kinetic;
      while (solver.time() < 0.1 && solver.particles().position[0].z() < 20.1e-3) solver.step();
      const double kept = solver.energy().kinetic / before;
      lowest = std::min(lowest, kept);
      highest = std::max(highest, kept);
    }
    checks.push_back({.what = fmt::format("e = {:g}: least energy kept, over two edge impacts", e),
                      .measured = lowest / two_edge_impacts(e),
                      .expected = 0.95,
                      .bound = Bound::at_least});
    checks.push_back({.what = fmt::format("e = {:g}: most energy kept, over a flat impact", e),
                      .measured = highest / (e * e),
                      .expected = 1.05,
                      .bound = Bound::at_most});
  }
  return checks;
}

}  // namespace

std::vector<VerificationCase> energy_cases() {
  const char* const conserved =
      "conservation of energy: without friction and at e = 1 an impact keeps it";
  return {
      {.name = "energy.elastic_impacts",
       .title = "Elastic impacts of spheres, boxes, hulls and crescents keep their energy",
       .reference = conserved,
       .remark =
           "A contact search transfers the recoverable energy of the old patches to the new ones. "
           "What remains is the error of the time step at the start and the end of a contact: "
           "50 steps in a quarter period.",
       .tier = Tier::quick,
       .run = [] { return elastic_impacts(12); }},
      {.name = "energy.many_elastic_impacts",
       .title = "The same, 300 random impacts of each kind",
       .reference = conserved,
       .remark = "As above.",
       .tier = Tier::full,
       .run = [] { return elastic_impacts(300); }},
      {.name = "energy.elastic_convergence",
       .title = "The error of the energy vanishes with the time step",
       .reference = "at least first order: half of the step, at most 0.6 of the error",
       .remark = "Impacts of stiff rotation, such as that of a corner, have the largest errors.",
       .tier = Tier::quick,
       .run = elastic_convergence},
      {.name = "energy.elastic_box",
       .title = "27 bodies in a closed box, half a second without friction or restitution loss",
       .reference = conserved,
       .remark = "Some hundred impacts; errors of single impacts have either sign.",
       .tier = Tier::full,
       .run = elastic_box},
      {.name = "energy.near_flat",
       .title = "A cube lands nearly flat: one face impact or two edge impacts",
       .reference =
           "rigid-body impacts of two edges in succession, each with e; a flat impact keeps e^2",
       .remark = "The tilt is up to 4 degrees. Between the two limits the edges touch at once.",
       .tier = Tier::quick,
       .run = near_flat_impacts}};
}

}  // namespace firn::verification
