// Shapes of closed meshes: checked, decomposed into convex parts, rounded.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "firn/mesh_conflicts.h"
#include "solver/shapes/convex_decomposition.h"
#include "solver/shapes/cut_trials.h"
#include "solver/shapes/merge_pieces.h"
#include "solver/shapes/shape_builder.h"
#include "solver/shapes/wall_thickness.h"

namespace firn {
namespace {

constexpr std::size_t kMaxTriangles = 20000;  // of a mesh with contact parts
// Parts of the smallest edge of the bounding box: wanted distance of hulls and mesh, allowed
// distance of swept parts and mesh, and least thickness of a piece.
constexpr double kTolerance = 0.016, kAllowed = 0.02, kThinnest = 0.05;
constexpr int kAttempts = 4;
constexpr double kThinner = 0.75;          // of the least thickness, where nothing else helps
constexpr int kMaxThinner = 2;             // times
constexpr std::size_t kPlanAgain = 10000;  // triangles that a repeated search plans on

}  // namespace

Shape make_mesh(const TriangleMesh& mesh, const ShapeOptions& options) {
  const std::string defects = inspect(mesh).to_message();
  if (!defects.empty()) {
    throw InputError("the mesh is not a solid (" + defects +
                     "); expected a closed surface facing outwards");
  }
  if (mesh.triangles.size() > kMaxTriangles) {
    throw InputError("the mesh has " + std::to_string(mesh.triangles.size()) +
                     " triangles; expected at most " + std::to_string(kMaxTriangles));
  }
  const std::string conflicts = find_conflicts(mesh).to_message();
  if (!conflicts.empty()) {
    throw InputError("the mesh bounds no solid: " + conflicts +
                     "; expected surfaces that do not cross and no solid inside another one");
  }
  const Shape begun = begin_shape(mesh, mass_properties(mesh), options);
  const double edge = begun.box.minCoeff();
  DecomposeOptions wanted;
  wanted.tolerance = kTolerance * edge;
  wanted.min_thickness = std::min(kThinnest * edge, 0.5 * wall_thickness(mesh));
  wanted.max_parts = options.max_parts;
  Shape best;
  // The search measures pieces one by one and by samples; where their union deviates by more than
  // allowed, it is repeated thoroughly, with a smaller tolerance, or with thinner pieces if these
  // were missing.
  int thinner = 0;
  CutTrials trials;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    Shape shape = begun;
    Decomposition found = decompose(mesh, wanted, &trials);
    mark_internal_faces(found.pieces, shape.box.norm());
    if (!(options.rounding >= 0)) shape.rounding = default_rounding(found.pieces, mesh, edge);
    for (const auto& piece : found.pieces) add_part(shape, piece);
    compute_bounding_radius(shape);
    find_neighboring_parts(shape);
    const Deviation deviation = measure_deviation(shape);
    shape.surface_deviation = deviation.largest();
    shape.deviation_reason =
        deviation.rounding > deviation.surplus ? "edges rounded"
        : found.part_limit_reached      ? fmt::format("max_parts = {} reached", options.max_parts)
        : found.thickness_limit_reached ? "further cuts would leave slivers"
                                        : "hulls of the parts over concave surface";
    const bool better = best.parts.empty() || shape.surface_deviation < best.surface_deviation;
    if (better) best = std::move(shape);
    // Stop if the deviation is small enough, or if rounding causes it and other cuts cannot reduce
    // it.
    if (best.surface_deviation <= kAllowed * edge || deviation.rounding > deviation.surplus) break;
    wanted.plan_triangles = kPlanAgain;
    wanted.thorough = true;
    // A limit was reached: better cuts would have left slivers, so thinner pieces are allowed next.
    if (found.thickness_limit_reached || found.part_limit_reached) {
      if (++thinner > kMaxThinner) break;
      wanted.min_thickness *= kThinner;
    } else {
      wanted.tolerance *= 0.8;
    }
  }
  return best;
}

}  // namespace firn
