#include "validation/verification/scenes.h"

#include <fmt/format.h>

#include <cmath>

namespace firn::scenes {

Interaction law(double friction, double restitution) {
  Interaction i;
  i.static_friction = i.dynamic_friction = friction;
  i.restitution = restitution;
  return i;
}

Model empty(const Interaction& ice_ice, const Interaction& ice_plastic) {
  Model model;
  model.materials.resize(2);
  model.materials[kIce] = {
      .name = "ice", .density = 916.7, .young_modulus = 1e7, .poisson_ratio = 0.33};
  model.materials[kPlastic] = {.name = "plastic", .young_modulus = 2e9};
  model.interactions = {ice_ice, ice_plastic, ice_plastic, law(0, 1)};
  return model;
}

ShapeOptions ice_options(double mass, double stiffness, double rounding) {
  ShapeOptions o;
  o.name = "body";
  o.material = kIce;
  o.density = 916.7;
  o.young_modulus = 1e7;
  o.mass = mass;
  o.stiffness = stiffness;
  o.rounding = rounding;
  return o;
}

Shape crescent(const CrescentParameters& parameters) {
  return make_crescent(parameters, ice_options(0, 0, 1e-3));
}

int add_shape(Model& model, Shape shape) {
  model.shapes.push_back(std::move(shape));
  return static_cast<int>(model.shapes.size()) - 1;
}

int add_particles(Model& model, int shape, int count) {
  const int first = static_cast<int>(model.particles.size());
  model.particles.resize(model.particles.size() + count, Particle{shape, 0});
  return first;
}

int add_plane(Model& model, const Vec3& point, const Vec3& normal, bool rigid) {
  Boundary b;
  b.name = fmt::format("plane {}", model.boundaries.size());
  b.material = kPlastic;
  b.rigid = rigid;
  b.kind = Boundary::Kind::plane;
  b.origin = point;
  b.orientation = Quat::FromTwoVectors(Vec3::UnitZ(), normal);
  model.boundaries.push_back(std::move(b));
  return static_cast<int>(model.boundaries.size()) - 1;
}

int add_panel(Model& model, const std::string& name, const Vec3& lower, const Vec3& upper,
              double rounding) {
  Boundary b;
  b.name = name;
  b.material = kPlastic;
  b.kind = Boundary::Kind::solid;
  b.origin = 0.5 * (lower + upper);
  const Vec3 half = 0.5 * (upper - lower);
  std::vector<HalfSpace> sides;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0})
      sides.push_back({sign * Vec3::Unit(axis), half[axis], false});
  }
  b.parts = {convex_part(sides, rounding)};
  model.boundaries.push_back(std::move(b));
  return static_cast<int>(model.boundaries.size()) - 1;
}

void add_box_of_planes(Model& model, const Vec3& corner, const Vec3& size) {
  add_plane(model, corner, Vec3::UnitZ(), false);
  for (int axis = 0; axis < 2; ++axis) {
    add_plane(model, corner, Vec3::Unit(axis), false);
    add_plane(model, corner + size, -Vec3::Unit(axis), false);
  }
}

Model body_on_plane(Shape shape, const Interaction& ice_plastic) {
  Model model = empty(ice_plastic, ice_plastic);
  add_particles(model, add_shape(model, std::move(shape)));
  add_plane(model, Vec3::Zero(), Vec3::UnitZ());
  return model;
}

Random::Random(std::uint64_t seed) : state_(seed) {}

// SplitMix64, Steele, Lea and Flood (2014).
std::uint64_t Random::next() {
  std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

double Random::uniform(double low, double high) {
  return low + (high - low) * (static_cast<double>(next() >> 11) * 0x1p-53);
}

// Shoemake (1992).
Quat Random::orientation() {
  const double u = uniform(0, 1);
  const double a = uniform(0, 2 * std::numbers::pi), b = uniform(0, 2 * std::numbers::pi);
  return Quat(std::sqrt(u) * std::cos(b), std::sqrt(1 - u) * std::sin(a),
              std::sqrt(1 - u) * std::cos(a), std::sqrt(u) * std::sin(b));
}

void scatter(Solver& solver, int first, int last, const Vec3& lower, const Vec3& upper,
             std::uint64_t seed) {
  Random random(seed);
  for (int particle = first; particle < last; ++particle) {
    const int shape = solver.model().particles[particle].shape;
    for (int tries = 0;; ++tries) {
      if (tries == 20000) throw RunError(fmt::format("no room for particle {}", particle));
      Vec3 at;
      for (int axis = 0; axis < 3; ++axis) at[axis] = random.uniform(lower[axis], upper[axis]);
      const Quat turn = random.orientation();
      if (solver.overlaps(shape, at, turn, 0.5e-3)) continue;
      solver.insert(particle, at, turn, Vec3::Zero(), Vec3::Zero());
      break;
    }
  }
}

ReposeBox repose_box(int cubes) {
  constexpr double kInch = 0.0254;
  const Vec3 half(23.5 * kInch / 2, 5.5 * kInch / 2, 0);
  const double lip = 5.75 * kInch / 2, thickness = 10e-3;
  ReposeBox box;
  Model& model = box.model = empty(law(0.1, 0.3), law(0.3, 0.3));
  add_particles(model, add_shape(model, crescent()), cubes);
  for (int axis = 0; axis < 2; ++axis) {
    const Vec3 wall = half[axis] * Vec3::Unit(axis);
    add_plane(model, -wall, Vec3::Unit(axis), false);
    add_plane(model, wall, -Vec3::Unit(axis), false);
  }
  const double reach = half.y() + thickness;  // panels pass under the walls
  add_panel(model, "floor left", {-half.x() - thickness, -reach, -thickness}, {-lip, reach, 0});
  add_panel(model, "floor right", {lip, -reach, -thickness}, {half.x() + thickness, reach, 0});
  box.door = add_panel(model, "door", {-lip, -reach, -thickness}, {lip, reach, 0});
  model.timestep = 2e-5;
  box.lower = Vec3(-half.x(), -half.y(), 0);
  box.upper = Vec3(half.x(), half.y(), 1.0);
  return box;
}

Vec3 center_of_mass(const Shape& shape, const Pose& pose) { return pose * shape.centroid; }

double mechanical(const Energy& e) { return e.kinetic + e.gravitational + e.elastic; }

void run(Solver& solver, double duration) {
  const auto steps = static_cast<std::uint64_t>(std::llround(duration / solver.model().timestep));
  for (std::uint64_t i = 0; i < steps; ++i) solver.step();
}

}  // namespace firn::scenes
