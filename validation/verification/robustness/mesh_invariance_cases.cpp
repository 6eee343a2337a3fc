// The same body and wall with meshes of other resolution and other convex parts.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "validation/verification/fixtures/check.h"
#include "validation/verification/fixtures/meshes.h"
#include "validation/verification/fixtures/wall_impact.h"
#include "validation/verification/robustness/cases.h"

namespace firn::verification {
namespace {

using scenes::kGravity;

ShapeOptions ice(double rounding) { return scenes::ice_options(0, 0, rounding); }

// --- Bodies. -------------------------------------------------------------------------------------

// Force and torque on a body in the first step, from the plane below it, which it overlaps.
struct Push {
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
};

Push push_on_plane(const Shape& shape, const Quat& turn, double overlap) {
  Model model = scenes::body_on_plane(shape, scenes::law(0.2, 0.5));
  model.gravity.setZero();
  model.timestep = 1e-7;
  const double lowest = lowest_point(shape, turn);
  Solver solver(model);
  solver.insert(0, {0, 0, -lowest - overlap}, turn, Vec3::Zero(), Vec3::Zero());
  solver.step();
  const Mat3 axes = (turn * shape.shape_from_body).toRotationMatrix();
  const Mat3 inertia = axes * shape.inertia.asDiagonal() * axes.transpose();
  // The first force acts for half a step: velocity Verlet.
  const double time = 0.5 * model.timestep;
  return {shape.mass * solver.particles().velocity[0] / time,
          inertia * solver.particles().angular_velocity[0] / time};
}

const std::vector<std::pair<std::string, Quat>>& postures() {
  static const std::vector<std::pair<std::string, Quat>> all = {
      {"flat", Quat::Identity()},
      {"on an edge", Quat(Eigen::AngleAxisd(45 * kDegToRad, Vec3::UnitX()))},
      {"on a corner", shortest_rotation(Vec3(1, 1, 1), Vec3(0.1, 0.05, -1))},
      {"tilted by 0.1 degrees",
       Quat(Eigen::AngleAxisd(0.1 * kDegToRad, Vec3(1, 0.3, 0).normalized()))}};
  return all;
}

std::vector<Check> cube_meshes() {
  constexpr double edge = 20e-3, overlap = 50e-6;
  std::vector<Check> checks;
  const Shape box = make_box(Vec3::Constant(edge), ice(1e-3));
  for (const auto& [posture, turn] : postures()) {
    const Push wanted = push_on_plane(box, turn, overlap);
    for (const int cells : {1, 2, 5, 10, 20}) {
      const Shape mesh = make_mesh(meshes::cube(edge, cells), ice(1e-3));
      const Push got = push_on_plane(mesh, turn, overlap);
      const std::string what =
          fmt::format("cube of {} facets {}: ", mesh.mesh.triangles.size(), posture);
      checks.push_back({.what = what + "force off that of the box",
                        .measured = (got.force - wanted.force).norm() / wanted.force.norm(),
                        .expected = 0,
                        .tolerance = 1e-6,
                        .bound = Bound::absolute});
      checks.push_back(
          {.what = what + "torque off that of the box, over force times edge",
           .measured = (got.torque - wanted.torque).norm() / (wanted.force.norm() * edge),
           .expected = 0,
           .tolerance = 1e-6,
           .bound = Bound::absolute});
    }
  }
  return checks;
}

// On its rim (upside down), its flat side, and its bottom.
std::vector<std::pair<std::string, Quat>> crescent_postures() {
  const double draft = CrescentParameters{}.draft;
  return {{"on its rim", Quat(Eigen::AngleAxisd(std::numbers::pi, Vec3::UnitX()))},
          {"on its side",
           shortest_rotation(Vec3(0, std::cos(draft), -std::sin(draft)), -Vec3::UnitZ())},
          {"on its bottom", Quat::Identity()}};
}

std::vector<Check> crescent_meshes() {
  constexpr double overlap = 200e-6, rounding = 1e-3;
  std::vector<Check> checks;
  CrescentParameters p = named_crescent("mass-matched", {}).parameters;
  p.facets = 1272;
  p.parts = 4;
  const Shape reference = make_crescent(p, ice(rounding));
  for (const auto& [posture, orientation] : crescent_postures()) {
    const Quat turn = orientation;  // clang 14 captures no structured binding
    const bool on_rim = posture == "on its rim";
    const double tolerance = on_rim ? 0.15 : 0.015;
    const Push wanted = push_on_plane(reference, turn, overlap);
    const auto compare = [&](const Shape& shape, const std::string& what) {
      const Push got = push_on_plane(shape, turn, overlap);
      checks.push_back({.what = what + "force",
                        .measured = got.force.norm(),
                        .expected = wanted.force.norm(),
                        .tolerance = tolerance,
                        .unit = "N"});
      checks.push_back(
          {.what = what + "torque off, over force times half the chord",
           .measured = (got.torque - wanted.torque).norm() / (wanted.force.norm() * 0.5 * p.chord),
           .expected = 0,
           .tolerance = tolerance,
           .bound = Bound::absolute});
    };
    for (const int facets : {68, 272, 1272, 5000}) {
      CrescentParameters q = p;
      q.facets = facets;
      const Shape shape = make_crescent(q, ice(rounding));
      compare(shape,
              fmt::format("crescent of {} facets {}: ", shape.mesh.triangles.size(), posture));
    }
    for (const int parts : {2, 3, 4, 6, 8, 12}) {
      if (on_rim && parts == 2) continue;  // neighbors: one patch of both ends
      CrescentParameters q = p;
      q.parts = parts;
      compare(make_crescent(q, ice(rounding)),
              fmt::format("crescent of {} parts {}: ", parts, posture));
    }
  }
  return checks;
}

// --- Walls. --------------------------------------------------------------------------------------

struct Wall {
  std::string name;
  std::vector<Boundary> boundaries;
};

Boundary box_wall(const std::string& name, const Vec3& lower, const Vec3& upper) {
  Boundary b;
  b.name = name;
  b.material = scenes::kPlastic;
  b.rigid = true;
  b.kind = Boundary::Kind::solid;
  std::vector<HalfSpace> sides;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0})
      sides.push_back({sign * Vec3::Unit(axis), 0.5 * (upper - lower)[axis], false});
  }
  b.parts = {convex_part(sides, 0)};
  b.origin = 0.5 * (lower + upper);
  return b;
}

// The same floor, 0.6 m square and solid below z = 0.
std::vector<Wall> floors() {
  constexpr double size = 0.6;
  std::vector<Wall> all = {{"plane", {sheet({.kind = ThinWall::Kind::plane})}},
                           {"box", {sheet({.kind = ThinWall::Kind::box, .size = size})}}};
  for (const int cells : {2, 3, 78}) {  // 8, 18 and 12168 triangles
    all.push_back({fmt::format("{} triangles", 2 * cells * cells),
                   {sheet({.kind = ThinWall::Kind::mesh, .cells = cells, .size = size})}});
  }
  return all;
}

struct Travel {
  Vec3 place = Vec3::Zero();  // m, of the center of mass at the end
  double highest = 0;         // m, of it on the way
};

Travel travel(const Shape& shape, const Quat& turn, const Wall& wall, const Vec3& velocity,
              double friction, double height, double time) {
  Model model = scenes::empty(scenes::law(friction, 0.3), scenes::law(friction, 0.3));
  scenes::add_particles(model, scenes::add_shape(model, shape));
  model.boundaries = wall.boundaries;
  model.timestep = 1e-5;
  Solver solver(model);
  const double lowest = lowest_point(shape, turn);
  // Set down in its own dent, so that it does not swing.
  const double dent = height > 0 ? 0 : shape.mass * kGravity / shape.stiffness;
  solver.insert(0, {-0.1, 0.013, height - dent - lowest}, turn, velocity, Vec3::Zero());
  Travel out;
  while (solver.time() < time) {
    scenes::run(solver, 10 * model.timestep);
    out.highest = std::max(out.highest, solver.particles().position[0].z());
  }
  out.place = solver.particles().position[0];
  return out;
}

struct Rider {
  std::string name;
  Shape shape;
  Quat turn = Quat::Identity();
};

std::vector<Rider> riders() {
  return {{"cube", make_box(Vec3::Constant(20e-3), ice(1e-3)), Quat::Identity()},
          {"sphere", make_sphere(10e-3, ice(0)), Quat::Identity()},
          {"crescent on its rim", scenes::crescent(),
           Quat(Eigen::AngleAxisd(std::numbers::pi, Vec3::UnitX()))},
          {"crescent on its bottom", scenes::crescent(), Quat::Identity()}};
}

// Bodies set down that slide and roll to rest, and a drop from 2 mm, on each of the floors.
std::vector<Check> same_floor() {
  std::vector<Check> checks;
  for (const Rider& rider : riders()) {
    for (const double height : {0.0, 2e-3}) {
      const Vec3 velocity(0.7, 0.1, 0);
      Travel wanted;
      for (const Wall& wall : floors()) {
        const Travel got = travel(rider.shape, rider.turn, wall, velocity, 0.2, height, 0.3);
        if (wall.name == "plane") {
          wanted = got;
          continue;
        }
        // Where points of contact wander over seams, their merging shifts the pressure a little.
        const bool exact = rider.name == "sphere" || wall.name == "box";
        const double rough = 2e-3 * 0.7 * 0.7 / (2 * 0.2 * kGravity);  // of the way
        checks.push_back({.what = fmt::format("{} from {:g} mm, floor of {}: place off that on "
                                              "the plane",
                                              rider.name, height * 1e3, wall.name),
                          .measured = (got.place - wanted.place).norm(),
                          .expected = 0,
                          .tolerance = exact ? 1e-6 : rough,
                          .bound = Bound::absolute,
                          .unit = "m"});
      }
    }
  }
  return checks;
}

// Panels side by side, each a separate boundary, crossed at right angles and aslant.
std::vector<Check> butted_panels() {
  constexpr double pitch = 30e-3, friction = 0.2;
  Wall panels{"panels", {}};
  for (int i = -10; i < 10; ++i) {
    panels.boundaries.push_back(
        box_wall(fmt::format("panel {}", i), {i * pitch, -0.3, -5e-3}, {(i + 1) * pitch, 0.3, 0}));
  }
  const Wall plane{"plane", {sheet({.kind = ThinWall::Kind::plane})}};
  std::vector<Check> checks;
  for (const Rider& rider : riders()) {
    const Vec3 velocity(0.7, 0.1, 0);
    const Travel on_plane = travel(rider.shape, rider.turn, plane, velocity, friction, 0, 0.4);
    const Travel on_panels = travel(rider.shape, rider.turn, panels, velocity, friction, 0, 0.4);
    const double distance = (on_plane.place - Vec3(-0.1, 0.013, on_plane.place.z())).norm();
    checks.push_back(
        {.what = rider.name + " over panels: place off that on the plane, over the way",
         .measured = (on_panels.place - on_plane.place).norm() / distance,
         .expected = 0,
         .tolerance = 0.015,
         .bound = Bound::absolute});
    checks.push_back({.what = rider.name + " over panels: highest above that on the plane",
                      .measured = on_panels.highest - on_plane.highest,
                      .expected = 20e-6,
                      .bound = Bound::at_most,
                      .unit = "m"});
  }
  return checks;
}

}  // namespace

std::vector<VerificationCase> mesh_cases() {
  return {
      {.name = "invariance.cube_meshes",
       .title = "A cube as box and as 12 to 4800 triangles",
       .reference = "the same solid: force and torque of the box",
       .remark = "Corners of the hull agree to 1e-9 of the size; 1e-6 of 50 um overlap.",
       .tier = Tier::quick,
       .run = cube_meshes},
      {.name = "invariance.crescent_meshes",
       .title = "A crescent of 68 to 5000 facets and 2 to 12 parts",
       .reference = "force and torque of the one of 1272 facets and 4 parts",
       .remark = "0.2 mm overlap. The force is K times the overlap of the lowest place whatever "
                 "the mesh; its center moves with the outline of the touching area, which "
                 "differs by the facets' sagittae: 1.5 % of the lever, as the crescents' "
                 "volume does at 68 facets.",
       .tier = Tier::quick,
       .run = crescent_meshes},
      {.name = "invariance.floor_meshes",
       .title = "A floor as plane, box, 8, 18 and 12168 triangles",
       .reference = "the same solid: the motion on the plane",
       .remark = "Cube, sphere and crescent slide, roll and hop for 0.3 s. The box and, for the "
                 "sphere, all floors agree to 1 um. A face on many triangles has many points, "
                 "which merge as they come near each other; the pressure under it shifts by "
                 "as much, and with it the rocking: 0.2 % of the way.",
       .tier = Tier::full,
       .run = same_floor},
      {.name = "invariance.butted_panels",
       .title = "Sliding over panels side by side",
       .reference = "the motion on a plane",
       .remark = "Panels of separate boundaries know nothing of each other: a body that has "
                 "sunk into one by w / K meets the edge of the next with its rounding. 1.5 % of "
                 "the way; panels that belong together should be one mesh.",
       .tier = Tier::quick,
       .run = butted_panels}};
}

}  // namespace firn::verification
