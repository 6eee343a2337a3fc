// Approximate convex decomposition of a closed mesh.
#pragma once

#include <cstddef>
#include <vector>

#include "firn/convex_part.h"

namespace firn {

struct DecomposeOptions {
  double tolerance = 0;   // m, wanted distance between the hulls' outer faces and the mesh
  double thinnest = 0;    // m, no cut leaves a piece thinner than this
  int max_parts = 1;      // at least 1
  bool thorough = false;  // a slower search, for solids that a quick one does not do justice to
  // Cuts are planned on a mesh of about so many triangles at most, and repeated on the whole one.
  std::size_t plan_triangles = 2500;
};

struct Decomposition {
  std::vector<std::vector<HalfSpace>> pieces;
  bool at_most_parts = false;         // a piece exceeds the tolerance, and there are max_parts
  bool stopped_by_thickness = false;  // a piece exceeds the tolerance, and no cut helps it
};

// Convex pieces, as half-spaces in mesh axes, that together hold the solid, its corners rounded to
// 2^-32 of the diagonal of its box. Faces on a cut carry exactly opposite planes on both sides;
// `internal` is not set. Pieces do not overlap by more than a millionth of the size. The mesh must
// be sound; the order of its vertices and triangles, its unit and its place do not matter. The same
// mesh gives the same pieces, bit by bit.
Decomposition decompose(const TriangleMesh& mesh, const DecomposeOptions& options);

// Thickness (m) that 95 % of the surface exceed: distance from a facet inwards to the opposite
// surface, over facets weighted by area.
double wall_thickness(const TriangleMesh& mesh);

}  // namespace firn
