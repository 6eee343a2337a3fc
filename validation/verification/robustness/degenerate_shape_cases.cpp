// Shapes at the edge of what makes sense: they work, or are refused with a reason.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "validation/verification/fixtures/check.h"
#include "validation/verification/fixtures/meshes.h"
#include "validation/verification/fixtures/scenes.h"
#include "validation/verification/robustness/robustness_cases.h"

namespace firn::verification {
namespace {

using scenes::kGravity;

ShapeOptions ice() { return scenes::ice_options(0, 0, -1); }

// --- Drops of odd shapes. ------------------------------------------------------------------------

// Height of the center of mass over the lowest point of the mesh, turned.
double height_over_lowest(const Shape& shape, const Quat& turn) {
  double lowest = 0;
  for (const Vec3& v : shape.mesh.vertices)
    lowest = std::min(lowest, (turn * (v - shape.centroid)).z());
  return -lowest;
}

// Lands flat at 1 m/s times the square root of its size in cm without gravity: speed after over
// speed before.
double flat_rebound(const Shape& shape, double e) {
  Model model = scenes::body_on_plane(shape, scenes::law(0, e));
  model.gravity.setZero();
  // Slow enough that it sinks in by a thousandth of its thickness.
  const double period = std::sqrt(shape.mass / shape.stiffness);
  const double speed = 1e-3 * shape.box.minCoeff() / period;
  model.timestep = advise_timestep(model, 20).timestep;
  Solver solver(model);
  const double gap = 1e-4 * shape.box.minCoeff();
  solver.insert(0, {0, 0, height_over_lowest(shape, Quat::Identity()) + gap}, Quat::Identity(),
                {0, 0, -speed}, Vec3::Zero());
  scenes::run(solver, gap / speed + 8 * period);
  return solver.particles().velocity[0].z() / speed;
}

struct Rest {
  double height = 0;  // of the lowest corner over the plane at the end, over the size
  double speed = 0;   // at the end, over sqrt(g size)
  double gained = 0;  // J, energy above that at the start, over that at the start
};

// Dropped aslant from its own size; after some bounces it lies still.
Rest drop(const Shape& shape, double friction) {
  Model model = scenes::body_on_plane(shape, scenes::law(friction, 0.3));
  model.timestep = advise_timestep(model, 10).timestep;
  Solver solver(model);
  const double size = shape.bounding_radius;
  const Quat turn(Eigen::AngleAxisd(0.3, Vec3(1, 2, 3).normalized()));
  solver.insert(0, {0, 0, 1.1 * size}, turn, Vec3::Zero(), Vec3::Zero());
  const double start = scenes::mechanical(solver.energy());
  Rest out;
  const double end = 9 * std::sqrt(2 * size / kGravity);
  while (solver.time() < end) {
    scenes::run(solver, 100 * model.timestep);
    out.gained = std::max(out.gained, scenes::mechanical(solver.energy()) / start - 1);
  }
  const ParticleState& p = solver.particles();
  out.height = (p.position[0].z() - height_over_lowest(shape, solver.shape_orientation(0))) / size;
  out.speed = p.velocity[0].norm() / std::sqrt(kGravity * size);
  return out;
}

struct Odd {
  std::string name;
  std::function<Shape()> make;
  bool flat;  // its lowest feature is a face, centered below the center of mass
};

std::vector<Odd> odd_shapes() {
  const auto box = [](double x, double y, double z) {
    return [=] { return make_box({x, y, z}, ice()); };
  };
  const auto mesh = [](TriangleMesh m) { return [m] { return make_mesh(m, ice()); }; };
  return {{"cube of 10 um", box(1e-5, 1e-5, 1e-5), true},
          {"plate 100:1", box(0.1, 0.1, 1e-3), true},
          {"plate 100:1 as mesh", mesh(make_box({0.1, 0.1, 1e-3}, ice()).mesh), true},
          {"needle 100:1", box(0.1, 1e-3, 1e-3), true},
          {"needle 1000:1 as mesh", mesh(make_box({0.1, 1e-4, 1e-4}, ice()).mesh), true},
          {"L", mesh(meshes::angle_bar()), false},
          {"U", mesh(meshes::channel()), true},
          {"ring", mesh(meshes::torus(25, 16)), false},
          {"ball of 9940 facets", mesh(meshes::ball(71, 71, 0)), false},
          {"ball with 140 dents", mesh(meshes::ball(70, 36, 0.06)), false}};
}

std::vector<Check> drops() {
  std::vector<Check> checks;
  for (const Odd& odd : odd_shapes()) {
    const Shape shape = odd.make();
    if (odd.flat) {
      checks.push_back({.what = odd.name + ": rebound of a flat landing, e = 0.5",
                        .measured = flat_rebound(shape, 0.5),
                        .expected = 0.500562,
                        .tolerance = 5e-3});
    }
    const Rest rest = drop(shape, 0.3);
    checks.push_back({.what = odd.name + ": energy gained in the drop, over that at the start",
                      .measured = rest.gained,
                      .expected = 1e-3,
                      .bound = Bound::at_most});
    // The convex parts may differ from the mesh by the surface deviation, in either direction.
    checks.push_back(
        {.what = odd.name + ": lowest corner of the mesh over the plane, over the size",
         .measured = rest.height,
         .expected = 0,
         .tolerance = 2e-3 + shape.surface_deviation / shape.bounding_radius,
         .bound = Bound::absolute});
  }
  return checks;
}

// --- What is refused. ----------------------------------------------------------------------------

std::string refusal(const std::function<Shape()>& make) {
  try {
    make();
  } catch (const InputError& e) {
    return e.what();
  }
  return {};
}

std::vector<Check> refusals() {
  TriangleMesh doubled;
  doubled.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  doubled.triangles = {{0, 1, 2}, {0, 2, 1}};
  TriangleMesh flat;
  flat.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 0.3, 0}};
  flat.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  TriangleMesh open = meshes::torus(25, 16);
  open.triangles.pop_back();
  const auto thin = [](double thickness) {
    return make_mesh(make_box({0.1, 0.1, 1e-3}, ice()).mesh.triangles.empty()
                         ? TriangleMesh{}
                         : meshes::scaled(make_box({0.1, 0.1, 1}, ice()).mesh, {1, 1, thickness}),
                     ice());
  };
  const std::vector<std::pair<std::string, std::function<Shape()>>> bad = {
      {"two triangles back to back", [&] { return make_mesh(doubled, ice()); }},
      {"a flat tetrahedron", [&] { return make_mesh(flat, ice()); }},
      {"a ring with a hole in its skin", [&] { return make_mesh(open, ice()); }},
      {"no triangles", [] { return make_mesh({}, ice()); }},
      {"a plate 1e8:1", [&] { return thin(1e-9); }},
      {"corners in one plane",
       [] {
         return make_convex({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 1e-16}}, ice());
       }},
      {"three corners",
       [] {
         return make_convex({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, ice());
       }},
      {"a box without height",
       [] {
         return make_box({1, 1, 0}, ice());
       }},
      {"a rounding of half the thickness",
       [] {
         ShapeOptions o = ice();
         o.rounding = 0.5e-3;
         return make_box({0.1, 0.1, 1e-3}, o);
       }},
      {"more than 20000 triangles", [] { return make_mesh(meshes::ball(142, 72, 0), ice()); }}};
  std::vector<Check> checks;
  for (const auto& [what, make] : bad) {
    const std::string said = refusal(make);
    const bool one_line = !said.empty() && said.find('\n') == std::string::npos;
    checks.push_back({.what = fmt::format("{}: refused, \"{}\"", what, said),
                      .measured = double(one_line),
                      .expected = 1,
                      .bound = Bound::at_least});
  }
  return checks;
}

// --- Fine meshes. --------------------------------------------------------------------------------

std::vector<Check> fine_meshes() {
  CrescentParameters p = named_crescent("mass-matched", {}).parameters;
  std::vector<Check> checks;
  for (const int facets : {1272, 19990}) {
    p.facets = facets;
    const Shape drawn = make_crescent(p, ice());
    const Shape cut = make_mesh(crescent_mesh(p), ice());
    const std::string what =
        fmt::format("crescent of {} facets, cut by itself: ", drawn.mesh.triangles.size());
    checks.push_back({.what = what + "parts",
                      .measured = double(cut.parts.size()),
                      .expected = 12,
                      .bound = Bound::at_most});
    checks.push_back({.what = what + "deviation of the parts from the mesh",
                      .measured = cut.surface_deviation,
                      .expected = 0.02 * cut.box.minCoeff(),
                      .bound = Bound::at_most,
                      .unit = "m"});
    checks.push_back({.what = what + "inertia about y",
                      .measured = cut.inertia.y(),
                      .expected = drawn.inertia.y(),
                      .tolerance = 1e-9,
                      .unit = "kg m^2"});
  }
  constexpr double radius = 10e-3;
  for (const auto& [around, up] : {std::pair{46, 23}, {100, 50}, {140, 71}}) {
    const Shape ball = make_mesh(meshes::ball(around, up, 0), ice());
    // The middle of the largest facet lies this far inside the sphere.
    const double half_edge = std::numbers::pi * radius / up;
    checks.push_back({.what = fmt::format("ball of {} facets: deviation of the part from the mesh",
                                          ball.mesh.triangles.size()),
                      .measured = ball.surface_deviation,
                      .expected = ball.rounding + half_edge * half_edge / radius,
                      .bound = Bound::at_most,
                      .unit = "m"});
  }
  const Shape ring = make_mesh(meshes::torus(125, 80), ice());
  const double exact = 2 * std::numbers::pi * std::numbers::pi * 10e-3 * 4e-3 * 4e-3;
  checks.push_back({.what = "ring of 20000 facets: volume",
                    .measured = ring.volume,
                    .expected = exact,
                    .tolerance = 2e-3,
                    .unit = "m^3"});
  checks.push_back({.what = "ring of 20000 facets: parts",
                    .measured = double(ring.parts.size()),
                    .expected = 64,
                    .bound = Bound::at_most});
  checks.push_back({.what = "ring of 20000 facets: deviation over the thickness of the ring",
                    .measured = ring.surface_deviation / 8e-3,
                    .expected = 0.02,
                    .bound = Bound::at_most});
  return checks;
}

}  // namespace

std::vector<VerificationCase> degenerate_shape_cases() {
  return {
      {.name = "robustness.odd_shapes",
       .title = "Drops of flat, thin, small and badly cut shapes",
       .reference = "rebound e' of a flat landing; energy never grows; the body comes to lie on "
                    "the plane with its own lowest corner",
       .remark = "Flat landings sink in by 0.1 % of the thickness: 0.5 %. Heights to 0.2 % of the "
                 "size and the contact deviation, which is what the cut costs; energy to 0.1 %, "
                 "the energy that a change of the touching set may store.",
       .tier = Tier::full,
       .run = drops},
      {.name = "robustness.refused_shapes",
       .title = "Shapes that are none are refused in one line",
       .reference = "an InputError of one sentence",
       .remark = "",
       .tier = Tier::quick,
       .run = refusals},
      {.name = "robustness.fine_meshes",
       .title = "Meshes of up to 20 000 facets",
       .reference = "mass and inertia of the mesh; parts within the stated deviation; volume of a "
                    "torus 2 pi^2 R r^2",
       .remark = "Deviations: 0.1 mm for the crescent (0.2 % of its box diagonal is what counts "
                 "as convex), sagitta of a facet and rounding for the ball.",
       .tier = Tier::full,
       .run = fine_meshes}};
}

}  // namespace firn::verification
