// Shapes of closed meshes: checked, decomposed into convex parts, rounded.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "solver/decompose.h"
#include "solver/mesh_conflicts.h"
#include "solver/shape_makers.h"

namespace firn {
namespace {

constexpr std::size_t kMaxCuts = 32;          // of one part
constexpr std::size_t kMaxTriangles = 20000;  // of a mesh with contact parts
// Parts of the smallest edge of the bounding box: wanted distance of hulls and mesh, allowed
// distance of swept parts and mesh, and least thickness of a piece.
constexpr double kTolerance = 0.016, kAllowed = 0.02, kThinnest = 0.05;
constexpr double kThinner = 0.75;  // of the least thickness, where nothing else helps

double area_of(const std::vector<Vec3>& polygon) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 1; k + 1 < polygon.size(); ++k) {
    sum += (polygon[k] - polygon[0]).cross(polygon[k + 1] - polygon[0]);
  }
  return 0.5 * sum.norm();
}

// The part of a convex polygon within a piece.
std::vector<Vec3> clipped(std::vector<Vec3> polygon, const std::vector<HalfSpace>& piece) {
  for (const auto& h : piece) {
    std::vector<Vec3> rest;
    for (std::size_t k = 0; k < polygon.size(); ++k) {
      const Vec3 &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
      const double from = h.normal.dot(a) - h.offset, to = h.normal.dot(b) - h.offset;
      if (from <= 0) rest.push_back(a);
      if ((from < 0 && to > 0) || (from > 0 && to < 0)) {
        rest.push_back(a + from / (from - to) * (b - a));
      }
    }
    polygon = std::move(rest);
    if (polygon.size() < 3) return {};
  }
  return polygon;
}

// Marks the faces that lie wholly inside or against other pieces: they are cuts, not surface. By
// area, as pieces do not overlap: what the others hold of the face, lifted a little, is added up.
void mark_cuts(std::vector<std::vector<HalfSpace>>& pieces, double size) {
  constexpr double kLift = 1e-5;      // over the size
  constexpr double kRelative = 1e-3;  // of the area; and a rim as wide as three lifts
  std::vector<ConvexPart> parts;
  for (const auto& piece : pieces) parts.push_back(convex_part(piece, 0));
  const auto original = pieces;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    std::size_t cuts = 0;
    for (const auto& face : parts[i].faces) {
      if (cuts == kMaxCuts) break;
      std::vector<Vec3> polygon;
      for (int k = 0; k < face.count; ++k) {
        polygon.push_back(parts[i].vertex(parts[i].loops[face.first + k]) +
                          kLift * size * face.normal);
      }
      double rim = 0;
      for (std::size_t k = 0; k < polygon.size(); ++k) {
        rim += (polygon[(k + 1) % polygon.size()] - polygon[k]).norm();
      }
      double open = area_of(polygon);
      const double allowed = kRelative * open + 3 * kLift * size * rim;
      for (std::size_t j = 0; j < pieces.size() && open > allowed; ++j) {
        const double reach = parts[i].bounding_radius + parts[j].bounding_radius;
        if (j == i || (parts[i].center - parts[j].center).norm() > reach) continue;
        open -= area_of(clipped(polygon, original[j]));
      }
      if (open > allowed) continue;
      for (auto& h : pieces[i]) {
        h.internal |= h.normal == face.normal && std::abs(h.offset - face.offset) < 1e-9 * size;
      }
      ++cuts;
    }
  }
}

}  // namespace

Shape make_mesh(const TriangleMesh& mesh, const ShapeOptions& options) {
  const std::string defects = inspect(mesh).sentence();
  if (!defects.empty()) {
    throw InputError("the mesh is no solid (" + defects +
                     "); expected a closed surface facing outwards");
  }
  if (mesh.triangles.size() > kMaxTriangles) {
    throw InputError("the mesh has " + std::to_string(mesh.triangles.size()) +
                     " triangles; expected at most " + std::to_string(kMaxTriangles));
  }
  const std::string conflicts = find_conflicts(mesh).sentence();
  if (!conflicts.empty()) {
    throw InputError("the mesh bounds no solid: " + conflicts +
                     "; expected surfaces that do not cross and no solid inside another one");
  }
  const Shape begun = begin_shape(mesh, mass_properties(mesh), options);
  const double edge = begun.box.minCoeff();
  DecomposeOptions wanted;
  wanted.tolerance = kTolerance * edge;
  wanted.thinnest = std::min(kThinnest * edge, 0.5 * wall_thickness(mesh));
  wanted.max_parts = options.max_parts;
  Shape best;
  // The search measures pieces one by one and by samples; where their union deviates by more than
  // allowed, it is repeated with a smaller tolerance, or with thinner pieces if these were missing.
  for (int attempt = 0; attempt < 3; ++attempt) {
    Shape shape = begun;
    Decomposition found = decompose(mesh, wanted);
    mark_cuts(found.pieces, shape.box.norm());
    if (!(options.rounding >= 0)) shape.rounding = default_rounding(found.pieces, mesh, edge);
    for (const auto& piece : found.pieces) add_part(shape, piece);
    set_reach(shape);
    find_neighbours(shape);
    const Deviation deviation = measure_deviation(shape);
    shape.contact_deviation = deviation.largest();
    shape.deviation_reason =
        deviation.rounding > deviation.surplus ? "edges rounded"
        : found.at_most_parts        ? fmt::format("max_parts = {} reached", options.max_parts)
        : found.stopped_by_thickness ? "further cuts would leave slivers"
                                     : "hulls of the parts over concave surface";
    const bool better = best.parts.empty() || shape.contact_deviation < best.contact_deviation;
    if (better) best = std::move(shape);
    // Neither more parts nor other cuts help then.
    if (best.contact_deviation <= kAllowed * edge || deviation.rounding > deviation.surplus ||
        found.at_most_parts) {
      break;
    }
    if (found.stopped_by_thickness) {
      wanted.thinnest *= kThinner;
    } else {
      wanted.tolerance *= 0.8;
    }
  }
  return best;
}

}  // namespace firn
