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
constexpr double kTolerance = 0.017, kAllowed = 0.02, kThinnest = 0.05;

bool contains(const std::vector<HalfSpace>& piece, const Vec3& p) {
  return std::all_of(piece.begin(), piece.end(),
                     [&p](const HalfSpace& h) { return h.normal.dot(p) <= h.offset; });
}

// Points spread over a face, at `lift` above it.
std::vector<Vec3> points_above(const ConvexPart& part, const ConvexPart::Face& face, double lift) {
  Vec3 middle = Vec3::Zero();
  for (int k = 0; k < face.count; ++k) middle += part.vertex(part.loops[face.first + k]);
  middle /= face.count;
  std::vector<Vec3> points = {middle};
  for (int k = 0; k < face.count; ++k) {
    const Vec3 corner = part.vertex(part.loops[face.first + k]);
    const Vec3 next = part.vertex(part.loops[face.first + (k + 1) % face.count]);
    for (const Vec3& p : {corner, Vec3((corner + next) / 2)}) {
      for (const double s : {0.01, 0.5}) points.push_back(p + s * (middle - p));
    }
  }
  for (Vec3& p : points) p += lift * face.normal;
  return points;
}

// Marks the faces that lie wholly inside or against other pieces: they are cuts, not surface.
void mark_cuts(std::vector<std::vector<HalfSpace>>& pieces, double size) {
  std::vector<ConvexPart> parts;
  for (const auto& piece : pieces) parts.push_back(convex_part(piece, 0));
  const auto original = pieces;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const auto in_another = [&](const Vec3& p) {
      for (std::size_t j = 0; j < pieces.size(); ++j) {
        if (j != i && contains(original[j], p)) return true;
      }
      return false;
    };
    std::size_t cuts = 0;
    for (const auto& face : parts[i].faces) {
      const auto points = points_above(parts[i], face, 1e-5 * size);
      if (cuts == kMaxCuts || !std::all_of(points.begin(), points.end(), in_another)) continue;
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
  // that, it is repeated with a smaller tolerance.
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
    wanted.tolerance *= 0.8;
  }
  return best;
}

}  // namespace firn
