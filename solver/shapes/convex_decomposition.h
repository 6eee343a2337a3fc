// Approximate convex decomposition of a watertight mesh.
#pragma once

#include <cstddef>
#include <vector>

#include "firn/convex_part.h"
#include "firn/mesh.h"

namespace firn {

struct DecomposeOptions {
  double tolerance = 0;      // m, largest distance of the hulls' outer faces from the mesh
  double min_thickness = 0;  // m, no cut leaves a thinner piece
  int max_parts = 1;         // at least 1
  bool thorough = false;     // slower search, for solids whose deviation stays too large
  // Cuts are planned on a mesh simplified to about this number of triangles. They are then applied
  // to the mesh itself.
  std::size_t plan_triangles = 2500;
};

struct Decomposition {
  std::vector<std::vector<HalfSpace>> pieces;  // mesh axes, m
  bool part_limit_reached = false;       // a piece exceeds the tolerance, and there are max_parts
  bool thickness_limit_reached = false;  // a piece exceeds the tolerance, and no cut helps it
};

class CutTrials;

// Convex pieces whose union contains the solid, with its corners rounded to 2^-32 of the diagonal
// of its bounding box. Faces on a cut have exactly opposite planes on both sides; `internal` is not
// set. Pieces overlap by at most a millionth of the diagonal. The result does not depend on the
// order of vertices and triangles, the unit of length or the position of the mesh. Equal meshes
// give equal bits. The mesh must be watertight. Throws InputError for a flat mesh.
// `trials` saves time where the same mesh is decomposed again with other options: it must be empty
// or come from that mesh. It does not change the result.
Decomposition decompose(const TriangleMesh& mesh, const DecomposeOptions& options,
                        CutTrials* trials = nullptr);

}  // namespace firn
