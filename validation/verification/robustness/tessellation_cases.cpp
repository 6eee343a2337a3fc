// The same solid cut in other ways: the motion of a body must not depend on the cuts. Random
// members with fixed seeds.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "experiments/machine/parts.h"
#include "experiments/meshes/wall_solids.h"
#include "validation/verification/fixtures/closed_forms.h"
#include "validation/verification/fixtures/meshes.h"
#include "validation/verification/fixtures/wall_impact.h"

namespace firn::verification {

namespace {

using scenes::kDegree;
using scenes::Random;

// --- Floors, solid below z = 0. ------------------------------------------------------------------

struct Floor {
  std::string name;
  Boundary boundary;
};

Boundary rigid(std::vector<ConvexPart> parts) {
  Boundary b = sheet({.kind = ThinWall::Kind::plane});
  b.kind = Boundary::Kind::solid;
  b.parts = std::move(parts);
  return b;
}

Boundary mesh_floor(const TriangleMesh& mesh) { return rigid(boundary_parts(mesh, 2e-3)); }

// A mesh whose outline is not convex: two of its corners are missing.
Floor notched_floor(double size, std::uint64_t seed) {
  constexpr int kCells = 12;
  TriangleMesh mesh = meshes::irregular_floor(size, kCells, seed);
  mesh.triangles.erase(mesh.triangles.begin(), mesh.triangles.begin() + 2);
  mesh.triangles.erase(mesh.triangles.end() - 2, mesh.triangles.end());
  return {"mesh without two of its corners", mesh_floor(mesh)};
}

// Floors that contain the square of `size` (m) about the origin. Cells of the meshes have the
// widths (m) of `widths`.
std::vector<Floor> floors(double size, const std::vector<double>& widths, std::uint64_t seed) {
  std::vector<Floor> all;
  all.push_back({"box", sheet({.kind = ThinWall::Kind::box, .thickness = 2e-3, .size = size})});
  all.push_back({"two triangles", mesh_floor(meshes::irregular_floor(size, 1, seed))});
  for (const double width : widths) {
    const int cells = static_cast<int>(std::round(size / width));
    all.push_back({fmt::format("irregular mesh of {:g} mm", width * 1e3),
                   mesh_floor(meshes::irregular_floor(size, cells, seed + cells))});
  }
  const Solid square = make_container({.round = false, .length = size, .width = size});
  all.push_back({"floor of a square container", rigid(square.parts)});
  const Solid round = make_container({.round = true, .diameter = size * std::sqrt(2.0)});
  all.push_back({"floor of a round container", rigid(round.parts)});
  return all;
}

// --- Tilt stiffness. -----------------------------------------------------------------------------

constexpr double kEdge = 20e-3, kStiffness = 1e5, kRounding = 0.1e-3;

// N m/rad, of the lower face of the shape about an axis at `angle` through its middle.
double tilt_stiffness(const Shape& shape, const Boundary& floor, const Vec3& place, double angle) {
  constexpr double overlap = 50e-6, tilt = 1e-5;
  const Vec3 axis(std::cos(angle), std::sin(angle), 0);
  Model model = scenes::body_on_plane(shape, scenes::law(0, 0.5));
  model.boundaries = {floor};
  model.gravity.setZero();
  model.timestep = 1e-7;
  const auto moment = [&](double by) {
    const Quat turn(Eigen::AngleAxisd(by, axis));
    const Vec3 arm = turn * Vec3(0, 0, -kEdge / 2);  // middle of the face, from the centre of mass
    Solver solver(model);
    solver.insert(0, place - arm - Vec3(0, 0, overlap), turn, Vec3::Zero(), Vec3::Zero());
    solver.step();
    const double time = 0.5 * model.timestep;  // the first force acts for half a step
    const Mat3 axes = (turn * shape.shape_from_body).toRotationMatrix();
    const Vec3 torque =
        axes *
        (shape.inertia.asDiagonal() * (axes.transpose() * solver.particles().angular_velocity[0])) /
        time;
    const Vec3 force = shape.mass * solver.particles().velocity[0] / time;
    return axis.dot(torque - arm.cross(force));
  };
  return (moment(-tilt) - moment(tilt)) / (2 * tilt);
}

// A box cut into `count` boxes at random places, each time across the longest side of one of them.
Shape cut_box(const Vec3& size, int count, Random& random, double rounding, double stiffness) {
  struct Cut {
    Vec3 lower, upper;
  };
  std::vector<Cut> boxes = {{-size / 2, size / 2}};
  while (static_cast<int>(boxes.size()) < count) {
    const auto widest = std::ranges::max_element(
        boxes, {}, [](const Cut& c) { return (c.upper - c.lower).maxCoeff(); });
    Cut rest = *widest;
    int axis = 0;
    (rest.upper - rest.lower).maxCoeff(&axis);
    const double at = rest.lower[axis] + random.uniform(0.3, 0.7) * (rest.upper - rest.lower)[axis];
    widest->upper[axis] = rest.lower[axis] = at;
    boxes.push_back(rest);
  }
  const double density = 900;
  std::vector<Component> components;
  for (const Cut& c : boxes) {
    ShapeOptions options = scenes::ice_options(0, stiffness, rounding);
    options.density = density;
    components.push_back(
        {make_box(c.upper - c.lower, options), {Mat3::Identity(), 0.5 * (c.lower + c.upper)}});
  }
  return make_compound(components, scenes::ice_options(density * size.prod(), stiffness, rounding));
}

std::vector<Check> tilt() {
  const double flat = kEdge - 2 * kRounding;
  std::vector<Check> checks;
  Random random(20261);
  const auto check = [&](const Shape& shape, const Boundary& floor, const std::string& what) {
    constexpr int kPlaces = 12;
    Worst worst(what + ": tilt stiffness over K a^2 / 4", 0.02);
    for (int i = 0; i < kPlaces; ++i) {
      const Vec3 place(random.uniform(-0.01, 0.01), random.uniform(-0.01, 0.01), 0);
      const double angle = random.uniform(0, 2 * std::numbers::pi);
      worst.add(tilt_stiffness(shape, floor, place, angle), kStiffness * flat * flat / 4,
                fmt::format("at {:.4g}, {:.4g} m, axis at {:.0f} degrees", place.x(), place.y(),
                            angle / kDegree));
    }
    checks.push_back(worst.check());
  };
  const Shape cube =
      make_box(Vec3::Constant(kEdge), scenes::ice_options(7.2e-3, kStiffness, kRounding));
  const Boundary plane = sheet({.kind = ThinWall::Kind::plane});
  check(cube, plane, "cube on a plane");
  for (const Floor& f : floors(0.08, {20e-3, 5e-3, 2e-3, 0.5e-3}, 7))
    check(cube, f.boundary, "cube on: " + f.name);
  const Floor notched = notched_floor(0.08, 8);
  check(cube, notched.boundary, "cube on: " + notched.name);
  for (int count = 2; count <= 12; ++count) {
    check(cut_box(Vec3::Constant(kEdge), count, random, kRounding, kStiffness), plane,
          fmt::format("cube of {} boxes on a plane", count));
  }
  return checks;
}

// --- Impacts. ------------------------------------------------------------------------------------

struct Flight {
  Vec3 velocity = Vec3::Zero(), spin = Vec3::Zero();  // m/s, rad/s
};

// The body falls at 1 m/s from just above the floor.
Flight impact(const Shape& shape, const Boundary& floor, double restitution, const Vec3& place,
              const Quat& turn, double time) {
  Model model = scenes::body_on_plane(shape, scenes::law(0, restitution));
  model.boundaries = {floor};
  model.gravity.setZero();
  model.timestep = advise_timestep(model, 10).timestep;
  Solver solver(model);
  const double height = 5e-6 - lowest_point(shape, turn);
  solver.insert(0, place + Vec3(0, 0, height), turn, {0, 0, -1}, Vec3::Zero());
  scenes::run(solver, time);
  return {solver.particles().velocity[0], solver.particles().angular_velocity[0]};
}

std::vector<Check> bar_spin() {
  const Vec3 size(60e-3, 10e-3, 10e-3);
  const Quat turn = about(Vec3::UnitY(), 0.5) * about(Vec3::UnitX(), 45);
  Random random(31);
  const Boundary plane = sheet({.kind = ThinWall::Kind::plane});
  const auto spin = [&](const Shape& bar, const Boundary& floor, const Vec3& place) {
    return impact(bar, floor, 0.5, place, turn, 20e-3).spin.norm();
  };
  const Shape whole = cut_box(size, 1, random, kRounding, kStiffness);
  const double wanted = spin(whole, plane, Vec3::Zero());
  std::vector<Check> checks;
  for (const int pieces : {2, 3, 4, 6, 8, 12}) {
    Worst worst(fmt::format("bar of {} pieces: spin over that of the whole bar", pieces), 0.02);
    for (int i = 0; i < 10; ++i)
      worst.add(spin(cut_box(size, pieces, random, kRounding, kStiffness), plane, Vec3::Zero()),
                wanted, fmt::format("cut {}", i));
    checks.push_back(worst.check());
  }
  for (const Floor& f : floors(0.12, {40e-3, 10e-3, 5e-3}, 11)) {
    Worst worst(fmt::format("bar on: {}: spin over that on the plane", f.name), 0.02);
    for (int i = 0; i < 20; ++i) {
      const Vec3 place(random.uniform(-0.02, 0.02), random.uniform(-0.02, 0.02), 0);
      worst.add(spin(whole, f.boundary, place), wanted,
                fmt::format("at {:.4g}, {:.4g} m", place.x(), place.y()));
    }
    checks.push_back(worst.check());
  }
  return checks;
}

// The largest deviation of many, and where.
struct Largest {
  double value = 0;
  int where = 0;
  void add(double deviation, int member) {
    if (deviation > value) where = member;
    value = std::max(value, deviation);
  }
};

std::vector<Check> impacts(int count) {
  struct Body {
    std::string name;
    Shape shape;
  };
  const std::vector<Body> bodies = {
      {"spheres", sphere(10e-3, 4e-3, 1e5)},
      {"boxes", make_box({24e-3, 20e-3, 16e-3}, scenes::ice_options(7e-3, 1e5, kRounding))},
      {"crescents", make_crescent(named_crescent("mass-matched", {}).parameters,
                                  scenes::ice_options(13.7e-3, 1e5, kRounding))}};
  const Boundary plane = sheet({.kind = ThinWall::Kind::plane});
  const std::vector<Floor> all = floors(0.12, {40e-3, 20e-3, 10e-3, 5e-3, 2e-3}, 3);
  std::vector<Check> checks;
  for (const Body& body : bodies) {
    for (const double restitution : {0.3, 0.5}) {
      std::vector<Largest> rebound(all.size()), spin(all.size());
      Random random(97);
      for (int i = 0; i < count; ++i) {
        const Vec3 place(random.uniform(-0.02, 0.02), random.uniform(-0.02, 0.02), 0);
        const Quat turn = random.orientation();
        const Flight wanted = impact(body.shape, plane, restitution, place, turn, 10e-3);
        for (std::size_t k = 0; k < all.size(); ++k) {
          const Flight got = impact(body.shape, all[k].boundary, restitution, place, turn, 10e-3);
          rebound[k].add((got.velocity - wanted.velocity).norm(), i);
          spin[k].add((got.spin - wanted.spin).norm() * body.shape.bounding_radius, i);
        }
      }
      for (std::size_t k = 0; k < all.size(); ++k) {
        const auto add = [&](const char* what, const Largest& largest) {
          checks.push_back(
              {.what = fmt::format("{} of {} {}, e = {}, on: {} (member {})", what, count,
                                   body.name, restitution, all[k].name, largest.where),
               .measured = largest.value,
               .expected = 0.01,
               .bound = Bound::at_most,
               .unit = "m/s"});
        };
        add("velocity off that on the plane,", rebound[k]);
        add("spin times radius off that on the plane,", spin[k]);
      }
    }
  }
  return checks;
}

}  // namespace

std::vector<VerificationCase> tessellation_cases() {
  const std::string plane = "the same solid uncut, on a plane";
  return {
      {.name = "invariance.tilt_stiffness",
       .title = "Tilt stiffness of a face on any floor and in any pieces",
       .reference = "K a^2 / 4, a the edge of the flat part of the face",
       .remark = "Four points at the corners have K / 4 each.",
       .tier = Tier::quick,
       .run = tilt},
      {.name = "invariance.bar_spin",
       .title = "A falling bar in 1 to 12 pieces, and on floors with seams",
       .reference = plane,
       .remark = "60 x 10 x 10 mm, rolled by 45 degrees, 0.5 degrees from level, 1 m/s, e = 0.5.",
       .tier = Tier::quick,
       .run = bar_spin},
      {.name = "invariance.impacts_on_meshes",
       .title = "Random impacts on flat floors of many kinds",
       .reference = plane,
       .remark = "1 m/s, no friction. 1 % of the impact speed.",
       .tier = Tier::quick,
       .run = [] { return impacts(30); }},
      {.name = "invariance.many_impacts_on_meshes",
       .title = "300 random impacts on each of these floors",
       .reference = plane,
       .remark = "1 m/s, no friction. 1 % of the impact speed.",
       .tier = Tier::full,
       .run = [] { return impacts(300); }},
  };
}

}  // namespace firn::verification
