// Planes that are worth trying as the next cut of a piece.
#pragma once

#include <vector>

#include "solver/shapes/cut_piece.h"

namespace firn {

// In the order in which they are to be tried:
// - in the planes of the deepest facets, and through reflex edges: in the plane of either facet and
//   between the two;
// - across the deepest facets, along the principal axes of the surface and the normals of its
//   largest areas;
// - normal to these axes: through the middle, the deepest point, the quarters and the thirds.
// With `middle_only` the planes of the first kind are left out, and those of the third except the
// middle. Of planes that nearly coincide the first is kept. Nothing for a piece without surface.
std::vector<HalfSpace> candidate_planes(const CutPiece& piece,
                                        const std::vector<ReflexEdge>& reflex_edges,
                                        bool middle_only, const CutSettings& settings);

}  // namespace firn
