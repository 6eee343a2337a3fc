// The semicircular masonry arch.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "validation/verification/assemblies/structure_cases.h"
#include "validation/verification/fixtures/scenes.h"

namespace firn::verification {
namespace {

using namespace scenes;

// A semicircular arch of wedges with radial joints on a rigid floor; mean radius 1 m.
struct Arch {
  int voussoirs = 24;
  double thickness = 0.12;  // m
  double rounding = 2e-4;   // m
  double stiffness = 1e8;   // N/m
  double friction = 0.7;
};

// One wedge in the plane: corners of voussoir i, counted from the right springing.
std::vector<Vec3> wedge_section(const Arch& a, int i) {
  std::vector<Vec3> corners;
  for (const int j : {i, i + 1}) {
    const double angle = std::numbers::pi * j / a.voussoirs;
    for (const double side : {-0.5, 0.5}) {
      corners.push_back((1 + side * a.thickness) * Vec3(std::cos(angle), 0, std::sin(angle)));
    }
  }
  return corners;
}

// How far the crown comes down in `duration`.
double arch_fall(const Arch& a, double duration) {
  constexpr double kDepth = 0.2;
  Model model = empty(law(a.friction, 0.3), law(a.friction, 0.3));
  for (int i = 0; i < a.voussoirs; ++i) {
    std::vector<Vec3> corners;
    for (const Vec3& c : wedge_section(a, i)) {
      for (const double side : {-0.5, 0.5}) corners.push_back(c + side * kDepth * Vec3::UnitY());
    }
    ShapeOptions options = ice_options(0, a.stiffness, a.rounding);
    add_particles(model, add_shape(model, make_convex(corners, options)));
  }
  add_plane(model, Vec3::Zero(), Vec3::UnitZ());
  model.timestep = advise_timestep(model, 8).timestep;
  Solver solver(model);
  for (int i = 0; i < a.voussoirs; ++i) {
    solver.insert(i, model.shapes[i].centroid, Quat::Identity(), Vec3::Zero(), Vec3::Zero());
  }
  const int crown = a.voussoirs / 2;
  const double before = solver.particles().position[crown].z();
  run(solver, duration);
  return before - solver.particles().position[crown].z();
}

// Limit analysis (Heyman 1969: no tension, no crushing, no sliding) of the arch as it is cut: with
// hinges at the outer edge of the crown's joint and of the springings, the thrust line of a half
// arch must not leave the inner edges of the joints between. Returns the least margin over those
// joints, N m per m of depth and unit weight: negative is a mechanism. Edges are rounded: hinges
// lie that much inside.
double arch_margin(const Arch& a, double thickness) {
  Arch cut = a;
  cut.thickness = thickness;
  const double outer = 1 + thickness / 2 - a.rounding, inner = 1 - thickness / 2 + a.rounding;
  // Weight and its moment about the vertical axis, from the crown down.
  const auto weight_and_moment = [&](int i) {
    const std::vector<Vec3> c = wedge_section(cut, i);
    // Of a quadrilateral with parallel inner and outer sides, from its two triangles.
    const auto triangle = [](const Vec3& p, const Vec3& q, const Vec3& r) {
      const double area = 0.5 * std::abs((q - p).cross(r - p).y());
      return std::pair(area, area * (p + q + r).x() / 3);
    };
    const auto [w1, m1] = triangle(c[0], c[1], c[2]);
    const auto [w2, m2] = triangle(c[1], c[2], c[3]);
    return std::pair(w1 + w2, m1 + m2);
  };
  const int half = a.voussoirs / 2;
  double weight = 0, moment = 0;
  for (int i = 0; i < half; ++i) {
    const auto [w, m] = weight_and_moment(i);
    weight += w;
    moment += m;
  }
  // Moments of the half arch about its springing's outer edge.
  const double thrust = (weight * outer - moment) / outer;
  double margin = 1e9;
  weight = moment = 0;
  for (int i = half - 1; i > 0; --i) {
    const auto [w, m] = weight_and_moment(i);
    weight += w;
    moment += m;
    const double angle = std::numbers::pi * i / a.voussoirs;
    const Vec3 hinge = inner * Vec3(std::cos(angle), 0, std::sin(angle));
    // Moments about the inner edge: the thrust at the crown moves the line outwards from it, the
    // weight inwards.
    margin = std::min(margin, thrust * (outer - hinge.z()) - (weight * hinge.x() - moment));
  }
  return margin;
}

double least_thickness(const Arch& a) {
  double low = 0.01, high = 0.5;
  while (high - low > 1e-9) {
    const double middle = 0.5 * (low + high);
    (arch_margin(a, middle) < 0 ? low : high) = middle;
  }
  return high;
}

std::vector<Check> arches(const std::vector<int>& counts) {
  std::vector<Check> checks;
  Arch fine;
  fine.voussoirs = 2000;
  fine.rounding = 0;
  checks.push_back({.what = "least t/R by limit analysis, 2000 voussoirs",
                    .measured = least_thickness(fine),
                    .expected = 0.107478,
                    .tolerance = 1e-4});
  const auto check = [&](Arch a, double t, bool stand) {
    a.thickness = t;
    const std::string what =
        fmt::format("{} voussoirs, K {:.0e} N/m, t/R {:.4f}, {:.3f} of the least: crown {} by",
                    a.voussoirs, a.stiffness, t, t / least_thickness(a), stand ? "sinks" : "falls");
    const double fall = arch_fall(a, 1.0);
    checks.push_back(stand ? stands(what, fall, 2e-3) : falls(what, fall, 0.1));
  };
  for (const int voussoirs : counts) {
    Arch a;
    a.voussoirs = voussoirs;
    const double least = least_thickness(a);
    check(a, 0.12, true);
    check(a, 1.05 * least, true);
    check(a, 0.99 * least, false);
    check(a, 0.095, false);
  }
  return checks;
}

// The stiffer the arch, the less it drops when it takes up its own weight.
std::vector<Check> stiff_arch() {
  std::vector<Check> checks;
  Arch a;
  const double least = least_thickness(a);
  for (const auto& [stiffness, factor] : {std::pair(1e8, 1.04), {1e9, 1.015}}) {
    a.stiffness = stiffness;
    for (const double f : {factor, 0.995}) {
      a.thickness = f * least;
      const std::string what =
          fmt::format("K {:.0e} N/m, {:.3f} of the least thickness: crown {} by", stiffness, f,
                      f > 1 ? "sinks" : "falls");
      const double fall = arch_fall(a, 1.5);
      checks.push_back(f > 1 ? stands(what, fall, 2e-3) : falls(what, fall, 0.1));
    }
  }
  return checks;
}

}  // namespace

std::vector<VerificationCase> arch_cases() {
  return {
      {.name = "structure.arch",
       .title = "Semicircular masonry arch",
       .reference =
           "least t/R 0.107478 with radial joints (Heyman 1969, Milankovitch 1907); for the "
           "arch as it is cut, by limit analysis of the actual wedges and rounded edges",
       .remark =
           "Limit analysis assumes rigid blocks that take up their load slowly. Here gravity is "
           "there at once: joints close by their overlap, the crown drops and has to be "
           "caught, which needs a little more thickness, 3.5 % at K = 1e8 N/m (see "
           "structure.stiff_arch). So 0.12 and 1.05 of the least must stand, 0.99 of it and "
           "0.095 fall. Friction 0.7: no sliding.",
       .tier = Tier::quick,
       .run = [] { return arches({24}); }},
      {.name = "structure.arches",
       .title = "Semicircular arch, other numbers of voussoirs",
       .reference = "as structure.arch",
       .remark = "As structure.arch.",
       .tier = Tier::full,
       .run =
           [] {
             return arches({20, 32, 40});
           }},
      {.name = "structure.stiff_arch",
       .title = "Least thickness of the arch as it stiffens",
       .reference = "limit analysis of 24 rigid wedges, t/R 0.10750",
       .remark =
           "Bisection puts the contact's own limit between 1.0325 and 1.035 of the least "
           "thickness at K = 1e8 N/m and between 1.010 and 1.0125 at 1e9: the excess falls as "
           "1 / sqrt(K) to nothing, as the drop does.",
       .tier = Tier::full,
       .run = stiff_arch}};
}

}  // namespace firn::verification
