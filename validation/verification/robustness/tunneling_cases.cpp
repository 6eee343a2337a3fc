// Fast bodies and thin walls: nothing gets through unnoticed.
#include <fmt/format.h>

#include <cmath>

#include "validation/verification/fixtures/check.h"
#include "validation/verification/fixtures/wall_impact.h"
#include "validation/verification/robustness/robustness_cases.h"

namespace firn::verification {
namespace {

struct Named {
  std::string name;
  Shape shape;
};

// A square ring of four bars 1 mm thick on four legs: its bounding box says nothing of how thin it
// is.
Shape cage() {
  const ShapeOptions o = scenes::ice_options(0, 0, -1);
  std::vector<Component> parts;
  const auto add = [&](const Vec3& size, const Vec3& place) {
    parts.push_back({make_box(size, o), {Mat3::Identity(), place}});
  };
  for (const double side : {-9.5e-3, 9.5e-3}) {
    add({20e-3, 1e-3, 1e-3}, {0, side, 0});
    add({1e-3, 18e-3, 1e-3}, {side, 0, 0});
    for (const double other : {-9.5e-3, 9.5e-3}) add({1e-3, 1e-3, 10e-3}, {side, other, 5.5e-3});
  }
  return make_compound(parts, o);
}

// A plate 20 x 20 x 1 mm, drawn aslant so that its bounding box hides how thin it is.
Shape slanting_plate() {
  const Mat3 turn(Eigen::AngleAxisd(0.7, Vec3(1, 0.5, 0.2).normalized()));
  std::vector<Vec3> corners;
  for (int i = 0; i < 8; ++i)
    corners.push_back(
        turn * Vec3(i & 1 ? 10e-3 : -10e-3, i & 2 ? 10e-3 : -10e-3, i & 4 ? 0.5e-3 : -0.5e-3));
  return make_convex(corners, scenes::ice_options(0, 0, -1));
}

Shape many_part_crescent() {
  CrescentParameters p = named_crescent("mass-matched", {}).parameters;
  p.parts = 12;
  return scenes::crescent(p);
}

std::vector<Named> bodies() {
  const auto box = [](const Vec3& size, double rounding) {
    return make_box(size, scenes::ice_options(0, 0, rounding));
  };
  return {{"sphere", make_sphere(10e-3, scenes::ice_options(0, 0, 0))},
          {"cube", box(Vec3::Constant(20e-3), 1e-3)},
          {"sharp cube", box(Vec3::Constant(20e-3), -1)},
          {"plate 20:1", box({20e-3, 20e-3, 1e-3}, -1)},
          {"slanting plate", slanting_plate()},
          {"cage", cage()},
          {"crescent", scenes::crescent()},
          {"crescent of 12 parts", many_part_crescent()}};
}

const std::vector<ThinWall>& kinds() {
  static const std::vector<ThinWall> all = {{.kind = ThinWall::Kind::plane},
                                            {.kind = ThinWall::Kind::box},
                                            {.kind = ThinWall::Kind::mesh, .cells = 3},
                                            {.kind = ThinWall::Kind::mesh, .cells = 15},
                                            {.kind = ThinWall::Kind::mesh, .cells = 60}};
  return all;
}

Impact random_shot(scenes::Random& random, double speed, int number) {
  Impact shot;
  shot.speed = speed;
  shot.target = {random.uniform(-10e-3, 10e-3), random.uniform(-10e-3, 10e-3), 0};
  if (number == 0) return shot;  // flat, along the normal
  shot.angle = random.uniform(0, 45) * kDegToRad;
  shot.turn = random.orientation();
  for (int k = 0; k < 3; ++k) shot.angular_velocity[k] = 20 * speed * random.uniform(-1, 1);
  return shot;
}

// No body has gone through the sheet or gained energy.
void add_flight_checks(const std::string& what, const char* through, const ImpactCounts& all,
                       std::vector<Check>& checks) {
  checks.push_back({.what = what + through,
                    .measured = double(all.through),
                    .expected = 0,
                    .bound = Bound::at_most});
  checks.push_back({.what = what + "kinetic energy after over before",
                    .measured = all.energy,
                    .expected = 1,
                    .bound = Bound::at_most});
}

std::vector<Check> thin_walls(const std::vector<double>& speeds,
                              const std::vector<double>& thicknesses, int shots, int finest) {
  std::vector<Check> checks;
  scenes::Random random(5);
  for (const Named& body : bodies()) {
    for (const double speed : speeds) {
      ImpactCounts all;
      for (ThinWall wall : kinds()) {
        if (wall.cells > finest) continue;
        for (const double thickness : thicknesses) {
          wall.thickness = thickness;
          for (int k = 0; k < shots; ++k)
            all.add(simulate_impact(body.shape, wall, random_shot(random, speed, k)));
          if (wall.kind == ThinWall::Kind::plane) break;
        }
      }
      const std::string what =
          fmt::format("{} at {:g} m/s, {} shots: ", body.name, speed, all.shots);
      add_flight_checks(what, "through a wall unnoticed", all, checks);
      if (speed > 3) continue;
      checks.push_back({.what = what + "runs stopped",
                        .measured = double(all.failed),
                        .expected = 0,
                        .bound = Bound::at_most});
    }
  }
  return checks;
}

// Two bodies, the first at rest. True when the second one flew through it: behind it at the end
// without a complaint.
Outcome collide_bodies(const Shape& target, const Shape& shape, const Impact& shot) {
  Model model = scenes::empty(scenes::law(0.1, 0.3), scenes::law(0.1, 0.3));
  scenes::add_particles(model, scenes::add_shape(model, target));
  scenes::add_particles(model, scenes::add_shape(model, shape));
  model.gravity.setZero();
  model.timestep = advise_timestep(model, shot.steps).timestep;
  Solver solver(model);
  const Vec3 direction(std::sin(shot.angle), 0, -std::cos(shot.angle));
  const double far = target.bounding_radius + shape.bounding_radius + 1e-4;
  solver.insert(0, Vec3::Zero(), Quat::Identity(), Vec3::Zero(), Vec3::Zero());
  solver.insert(1, shot.target - far * direction, shot.turn, shot.speed * direction, Vec3::Zero());
  const double before = solver.energy().kinetic;
  Outcome out;
  try {
    scenes::run(solver, 3 * far / shot.speed);
  } catch (const RunError& e) {
    out.end = End::failed;
    return out;
  }
  // A body that struck pushes the other one on ahead of itself.
  const ParticleState& p = solver.particles();
  const bool untouched = p.velocity[0].norm() == 0;
  const bool behind = (p.position[1] - p.position[0]).dot(direction) > 0;
  out.end = untouched || behind ? End::through : End::held;
  out.energy = solver.energy().kinetic / before;
  return out;
}

std::vector<Check> thin_particles() {
  std::vector<Check> checks;
  const auto box = [](const Vec3& size) { return make_box(size, scenes::ice_options(0, 0, -1)); };
  // Heavy, so that nothing knocks it out of the way.
  const Shape plate = make_box({40e-3, 40e-3, 1e-3}, scenes::ice_options(1, 0, -1));
  const std::vector<Named> shot_at_it = {
      {"plate 20:1", box({20e-3, 20e-3, 1e-3})},
      {"needle 20:1", box({1e-3, 1e-3, 20e-3})},
      {"sphere", make_sphere(2e-3, scenes::ice_options(0, 0, 0))},
      {"crescent", scenes::crescent()}};
  scenes::Random random(9);
  for (const Named& body : shot_at_it) {
    for (const double speed : {1.0, 10.0, 100.0}) {
      ImpactCounts all;
      for (int k = 0; k < 8; ++k) {
        Impact shot = random_shot(random, speed, k);
        shot.angle *= 0.5;
        shot.target *= 0.5;
        all.add(collide_bodies(plate, body.shape, shot));
      }
      const std::string what =
          fmt::format("{} at {:g} m/s on a plate 40:1, {} shots: ", body.name, speed, all.shots);
      add_flight_checks(what, "through it unnoticed", all, checks);
    }
  }
  return checks;
}

// Steps so long that a body is past a wall at the end of one: the run must stop.
std::vector<Check> long_steps() {
  std::vector<Check> checks;
  const Shape plate = make_box({20e-3, 20e-3, 1e-3}, scenes::ice_options(0, 0, -1));
  for (const double thickness : {0.2e-3, 1e-3, 5e-3}) {
    for (ThinWall wall : kinds()) {
      if (wall.kind == ThinWall::Kind::plane || wall.cells > 15) continue;
      wall.thickness = thickness;
      ImpactCounts all;
      for (const double distance : {0.5, 1.1, 2.0, 4.0}) {  // both thicknesses a step
        const double dt = distance * (thickness + 1e-3) / 100;
        Model model = scenes::body_on_plane(plate, scenes::law(0.1, 0.3));
        model.boundaries = {sheet(wall)};
        Impact shot;
        shot.speed = 100;
        shot.steps = advise_timestep(model, 1).timestep / dt;
        for (const double offset : {0.0, 0.3, 0.6}) {
          shot.target.x() = offset * 1e-2;
          all.add(simulate_impact(plate, wall, shot));
        }
      }
      checks.push_back(
          {.what = fmt::format("plate at 100 m/s, 0.5 to 4 thicknesses a step, wall {:g} mm, {} "
                               "cells: through unnoticed",
                               thickness * 1e3, wall.cells),
           .measured = double(all.through),
           .expected = 0,
           .bound = Bound::at_most});
    }
  }
  return checks;
}

// A corner that comes down next to a cut of the mesh and is past it at the end of the same step
// lies in pieces that it never entered from above.
struct Aim {
  double angle = 0;           // rad from the normal, in the plane of `azimuth`
  double azimuth = 0;         // rad about the normal
  Vec3 place = Vec3::Zero();  // m, where the corner crosses the surface
};

// Impulse of the wall along its normal on a cube whose lowest corner comes down at this place, over
// the step of the entry and the next, N s; 0 when it went in unseen.
double entry_impulse(const Shape& cube, const Boundary& wall, double speed, const Aim& aim) {
  Model model = scenes::body_on_plane(cube, scenes::law(0, 0.3));
  model.boundaries = {wall};
  model.gravity.setZero();
  model.timestep = advise_timestep(model, 10).timestep;
  const Quat turn = shortest_rotation(Vec3(1, 1, 1).normalized(), Vec3(0.1, 0.2, -1).normalized());
  const Vec3 corner = turn * Vec3::Constant(10e-3);
  const Vec3 direction = Eigen::AngleAxisd(aim.azimuth, Vec3::UnitZ()) *
                         Vec3(std::sin(aim.angle), 0, -std::cos(aim.angle));
  const Vec3 velocity = speed * direction;
  // One and a half steps before the corner crosses the surface of the sheet.
  const Vec3 start = aim.place - corner - (1.5 * model.timestep) * velocity;
  Solver solver(model);
  solver.insert(0, start, turn, velocity, Vec3::Zero());
  for (int i = 0; i < 3; ++i) solver.step();
  return model.shapes[0].mass * (solver.particles().velocity[0].z() - velocity.z());
}

std::vector<Check> seam_entry() {
  std::vector<Check> checks;
  const Shape cube = make_box(Vec3::Constant(20e-3), scenes::ice_options(0, 0, -1));
  const ThinWall triangles{.kind = ThinWall::Kind::mesh, .thickness = 1e-3, .cells = 15};
  const Boundary mesh = sheet(triangles);
  const Boundary box = sheet({.kind = ThinWall::Kind::box, .thickness = triangles.thickness});
  const double cell = triangles.size / triangles.cells;
  const Vec3 four(0.5 * cell, 0.5 * cell, 0), eight(1.5 * cell, 0.5 * cell, 0);  // meet there
  for (const double speed : {3.0, 30.0, 100.0}) {
    double worst = 0;
    int shots = 0;
    const auto shoot = [&](const Aim& aim) {
      const double expected = entry_impulse(cube, box, speed, aim);
      worst = std::max(worst, std::abs(entry_impulse(cube, mesh, speed, aim) / expected - 1));
      ++shots;
    };
    for (const Vec3& knot : {four, eight}) {
      for (const double aside : {0.0, 1e-9, 1e-7, 1e-6, 1e-5, 1e-4}) {
        const Vec3 place = knot + aside * Vec3(1, -0.5, 0);
        for (const double angle : {0.0, 10.0, 30.0, 45.0}) {
          for (int turn = 0; turn < 8; ++turn)
            shoot({angle * kDegToRad, 0.1 + turn * 45 * kDegToRad, place});
        }
      }
    }
    checks.push_back({.what = fmt::format("corner at {:g} m/s on knots of the mesh, {} shots: "
                                          "impulse over that of a box, less 1",
                                          speed, shots),
                      .measured = worst,
                      .expected = 1e-6,
                      .bound = Bound::at_most});
  }
  return checks;
}

constexpr const char* kReference =
    "A wall is a solid: a body comes back from it, or the run stops with a reason. Contacts take "
    "energy only, so a rebound is never faster than the impact.";

}  // namespace

std::vector<VerificationCase> tunneling_cases() {
  return {
      {.name = "robustness.thin_walls",
       .title = "Fast bodies on thin walls",
       .reference = kReference,
       .remark =
           "Walls of 0.2 mm as plane, box and 18 and 450 triangles; orientation, spin, angle "
           "up to 45 degrees and place at random. Stiffness is that of the shapes (0.01 GPa): up "
           "to 3 m/s every body must come back; above, one whose overlap exceeds half of its "
           "smallest edge may be refused. Counts have no tolerance.",
       .tier = Tier::quick,
       .run =
           [] {
             return thin_walls({3, 30}, {0.2e-3}, 2, 15);
           }},
      {.name = "robustness.thin_walls_sweep",
       .title = "Fast bodies on walls of 0.2 to 5 mm at 1 to 100 m/s",
       .reference = kReference,
       .remark = "As robustness.thin_walls, with 0.2, 0.5, 1, 2 and 5 mm, 7200 triangles too and "
                 "six speeds.",
       .tier = Tier::full,
       .run =
           [] {
             return thin_walls({1, 3, 10, 30, 60, 100}, {0.2e-3, 0.5e-3, 1e-3, 2e-3, 5e-3}, 4, 60);
           }},
      {.name = "robustness.seam_entry",
       .title = "Corners that enter on the seams of a mesh",
       .reference =
           "The seams of a mesh are not there: a box of the same outline gives the impulse.",
       .remark =
           "Half a step after it has crossed the surface within 0 to 0.1 mm of knots where four "
           "and eight triangles meet, the corner is in pieces that it came to through their cuts.",
       .tier = Tier::quick,
       .run = seam_entry},
      {.name = "robustness.thin_particles",
       .title = "Thin particles against thin particles",
       .reference = kReference,
       .remark = "The struck plate is free and at rest. Through: it was not pushed, or the other "
                 "body ends up behind it.",
       .tier = Tier::quick,
       .run = thin_particles},
      {.name = "robustness.long_steps",
       .title = "A step longer than the wall is thick",
       .reference = kReference,
       .remark = "Nothing can hold a body that jumps over a wall within one step; the sweep over "
                 "the step finds it out and stops the run.",
       .tier = Tier::quick,
       .run = long_steps}};
}

}  // namespace firn::verification
