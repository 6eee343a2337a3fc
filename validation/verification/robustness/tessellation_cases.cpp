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
#include "validation/verification/robustness/cases.h"

namespace firn::verification {

namespace {

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

Boundary mesh_floor(const TriangleMesh& mesh) { return rigid(wall_solids(mesh, 2e-3)); }

// A mesh whose outline is not convex: two of its corners are missing.
Floor notched_floor(double size, std::uint64_t seed) {
  constexpr int kCells = 12;
  TriangleMesh mesh = meshes::irregular_floor(size, kCells, seed);
  mesh.triangles.erase(mesh.triangles.begin(), mesh.triangles.begin() + 2);
  mesh.triangles.erase(mesh.triangles.end() - 2, mesh.triangles.end());
  return {"mesh without two of its corners", mesh_floor(mesh)};
}

// A plane floor that is not convex: an irregular mesh without some of its triangles.
class OpenFloor {
 public:
  enum class Outline { angle, channel, hole, scattered };

  OpenFloor(Outline outline, double size, int cells, std::uint64_t seed) : size_(size) {
    TriangleMesh mesh = meshes::irregular_floor(size, cells, seed);
    Random random(seed + 1);
    // Parts of the size. The openings are at least as wide as a cell.
    const double edge = random.uniform(0.1, 0.35), width = random.uniform(0.1, 0.2);
    std::vector<Vec3> centers;
    for (int i = 0; i < 4; ++i)
      centers.emplace_back(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), 0);
    const auto is_open = [&](const Vec3& x) {
      switch (outline) {
        case Outline::angle:
          return x.x() > edge - 0.3 && x.y() > edge - 0.2;
        case Outline::channel:
          return std::abs(x.x()) < width && x.y() > -edge;
        case Outline::hole:
          return std::abs(x.x()) < width && std::abs(x.y()) < width;
        case Outline::scattered:
          break;
      }
      return std::ranges::any_of(centers,
                                 [&](const Vec3& c) { return (x - c).norm() < 0.5 * width; });
    };
    std::erase_if(mesh.triangles, [&](const std::array<int, 3>& t) {
      const Vec3 middle =
          (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / (3 * size);
      if (!is_open(middle)) return false;
      open_.push_back({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
      return true;
    });
    boundary_ = mesh_floor(mesh);
  }
  const Boundary& boundary() const { return boundary_; }

  // A random place with a solid circle of radius `reach` (m) around it.
  Vec3 place(Random& random, double reach) const {
    constexpr int kTries = 100000;
    const double half = size_ / 2 - reach;
    for (int i = 0; i < kTries; ++i) {
      const Vec3 at(random.uniform(-half, half), random.uniform(-half, half), 0);
      if (std::ranges::none_of(open_, [&](const auto& t) { return distance(t, at) < reach; }))
        return at;
    }
    throw RunError("no solid place on the floor");
  }

 private:
  static double distance(const std::array<Vec3, 3>& t, const Vec3& at) {
    double least = std::numeric_limits<double>::infinity();
    bool inside = true;
    for (int i = 0; i < 3; ++i) {
      const Vec3 side = t[(i + 1) % 3] - t[i], to = at - t[i];
      inside = inside && side.cross(to).z() >= 0;
      const double along = std::clamp(side.dot(to) / side.squaredNorm(), 0.0, 1.0);
      least = std::min(least, (to - along * side).norm());
    }
    return inside ? 0 : least;
  }

  double size_;
  std::vector<std::array<Vec3, 3>> open_;
  Boundary boundary_;
};

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
    const Vec3 arm = turn * Vec3(0, 0, -kEdge / 2);  // middle of the face, from the center of mass
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
    LargestError worst(what + ": tilt stiffness over K a^2 / 4", 0.02);
    for (int i = 0; i < kPlaces; ++i) {
      const Vec3 place(random.uniform(-0.01, 0.01), random.uniform(-0.01, 0.01), 0);
      const double angle = random.uniform(0, 2 * std::numbers::pi);
      worst.add(tilt_stiffness(shape, floor, place, angle), kStiffness * flat * flat / 4,
                fmt::format("at {:.4g}, {:.4g} m, axis at {:.0f} degrees", place.x(), place.y(),
                            angle / kDegToRad));
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
  Vec3 velocity = Vec3::Zero(), angular_velocity = Vec3::Zero();  // m/s, rad/s
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
  const auto angular_speed = [&](const Shape& bar, const Boundary& floor, const Vec3& place) {
    return impact(bar, floor, 0.5, place, turn, 20e-3).angular_velocity.norm();
  };
  const Shape whole = cut_box(size, 1, random, kRounding, kStiffness);
  const double wanted = angular_speed(whole, plane, Vec3::Zero());
  std::vector<Check> checks;
  for (const int pieces : {2, 3, 4, 6, 8, 12}) {
    LargestError worst(fmt::format("bar of {} pieces: spin over that of the whole bar", pieces),
                       0.02);
    for (int i = 0; i < 10; ++i)
      worst.add(
          angular_speed(cut_box(size, pieces, random, kRounding, kStiffness), plane, Vec3::Zero()),
          wanted, fmt::format("cut {}", i));
    checks.push_back(worst.check());
  }
  for (const Floor& f : floors(0.12, {40e-3, 10e-3, 5e-3}, 11)) {
    LargestError worst(fmt::format("bar on: {}: spin over that on the plane", f.name), 0.02);
    for (int i = 0; i < 20; ++i) {
      const Vec3 place(random.uniform(-0.02, 0.02), random.uniform(-0.02, 0.02), 0);
      worst.add(angular_speed(whole, f.boundary, place), wanted,
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
      std::vector<Largest> rebound(all.size()), angular_velocity(all.size());
      Random random(97);
      for (int i = 0; i < count; ++i) {
        const Vec3 place(random.uniform(-0.02, 0.02), random.uniform(-0.02, 0.02), 0);
        const Quat turn = random.orientation();
        const Flight wanted = impact(body.shape, plane, restitution, place, turn, 10e-3);
        for (std::size_t k = 0; k < all.size(); ++k) {
          const Flight got = impact(body.shape, all[k].boundary, restitution, place, turn, 10e-3);
          rebound[k].add((got.velocity - wanted.velocity).norm(), i);
          angular_velocity[k].add(
              (got.angular_velocity - wanted.angular_velocity).norm() * body.shape.bounding_radius,
              i);
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
        add("spin times radius off that on the plane,", angular_velocity[k]);
      }
    }
  }
  return checks;
}

// --- Floors that are not convex. -----------------------------------------------------------------

struct OpenFloorFamily {
  const char* name;
  OpenFloor::Outline outline;
};
constexpr OpenFloorFamily kOpenFloors[] = {
    {"L", OpenFloor::Outline::angle},
    {"U", OpenFloor::Outline::channel},
    {"plate with a hole", OpenFloor::Outline::hole},
    {"mesh with four openings", OpenFloor::Outline::scattered}};

std::vector<Check> open_floor_tilt(int count) {
  const Shape cube =
      make_box(Vec3::Constant(kEdge), scenes::ice_options(7.2e-3, kStiffness, kRounding));
  const double flat = kEdge - 2 * kRounding;
  std::vector<Check> checks;
  for (const auto& [name, outline] : kOpenFloors) {
    LargestError worst(
        fmt::format("cube on: {}, {} members: tilt stiffness over K a^2 / 4", name, count), 0.01);
    for (int i = 0; i < count; ++i) {
      Random random(4100 + i);
      const OpenFloor floor(outline, 0.24, 6 + i % 13, 50 + i);
      const Vec3 place = floor.place(random, 0.75 * kEdge);
      const double angle = random.uniform(0, 2 * std::numbers::pi);
      worst.add(tilt_stiffness(cube, floor.boundary(), place, angle), kStiffness * flat * flat / 4,
                fmt::format("member {}", i));
    }
    checks.push_back(worst.check());
  }
  return checks;
}

std::vector<Check> open_floor_impacts(int count) {
  constexpr double restitution = 0.5, time = 10e-3;
  struct Body {
    std::string name;
    Shape shape;
    bool near_flat;
  };
  const Shape box = make_box({24e-3, 20e-3, 16e-3}, scenes::ice_options(7e-3, 1e5, kRounding));
  const std::vector<Body> bodies = {{"spheres", sphere(10e-3, 4e-3, 1e5), false},
                                    {"boxes", box, false},
                                    {"boxes near flat", box, true},
                                    {"crescents",
                                     make_crescent(named_crescent("mass-matched", {}).parameters,
                                                   scenes::ice_options(13.7e-3, 1e5, kRounding)),
                                     false}};
  const Boundary uncut = sheet({.kind = ThinWall::Kind::box, .thickness = 2e-3, .size = 0.5});
  std::vector<Check> checks;
  for (const Body& body : bodies) {
    for (const OpenFloorFamily& family : kOpenFloors) {
      Largest rebound, angular_velocity;
      for (int i = 0; i < count; ++i) {
        Random random(5200 + i);
        const OpenFloor floor(family.outline, 0.4, 8 + i % 17, 90 + i);
        const Quat turn = body.near_flat ? about(Vec3::UnitX(), random.uniform(-3, 3)) *
                                               about(Vec3::UnitY(), random.uniform(-3, 3)) *
                                               about(Vec3::UnitZ(), random.uniform(0, 360))
                                         : random.orientation();
        const Vec3 place = floor.place(random, 1.05 * body.shape.bounding_radius);
        const Flight wanted = impact(body.shape, uncut, restitution, place, turn, time);
        Flight got;
        try {
          got = impact(body.shape, floor.boundary(), restitution, place, turn, time);
        } catch (const RunError& error) {
          throw RunError(
              fmt::format("{} on: {}, member {}: {}", body.name, family.name, i, error.what()));
        }
        rebound.add((got.velocity - wanted.velocity).norm(), i);
        angular_velocity.add(
            (got.angular_velocity - wanted.angular_velocity).norm() * body.shape.bounding_radius,
            i);
      }
      const auto add = [&](const char* what, const Largest& largest) {
        checks.push_back({.what = fmt::format("{} of {} {} on: {} (member {})", what, count,
                                              body.name, family.name, largest.where),
                          .measured = largest.value,
                          .expected = 0.002,
                          .bound = Bound::at_most,
                          .unit = "m/s"});
      };
      add("velocity off that on an uncut floor,", rebound);
      add("spin times radius off that on an uncut floor,", angular_velocity);
    }
  }
  return checks;
}

std::vector<Check> open_floors(int count) {
  std::vector<Check> checks = open_floor_tilt(count);
  std::ranges::move(open_floor_impacts(count), std::back_inserter(checks));
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
      {.name = "invariance.open_floors",
       .title =
           "Flat floors that are not convex: an L, a U, a plate with a hole, a mesh with openings",
       .reference = "K a^2 / 4; the same impact on an uncut floor",
       .remark =
           "Irregular meshes of 13 to 50 mm. The circle around the body is solid floor. 1 m/s, "
           "e = 0.5, no friction. 0.2 % of the impact speed.",
       .tier = Tier::quick,
       .run = [] { return open_floors(16); }},
      {.name = "invariance.many_open_floors",
       .title = "300 random floors of each of these kinds",
       .reference = "K a^2 / 4; the same impact on an uncut floor",
       .remark = "As above.",
       .tier = Tier::full,
       .run = [] { return open_floors(300); }},
  };
}

}  // namespace firn::verification
