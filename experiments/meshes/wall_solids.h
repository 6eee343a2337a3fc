// Convex parts of boundaries that are given as surfaces.
#pragma once

#include <vector>

#include "firn/convex_part.h"
#include "firn/mesh.h"

namespace firn {

// Convex parts behind the triangles of a surface. A closed mesh that faces inwards is a container.
// A closed convex mesh becomes one part. Any other mesh, open or closed, becomes one prism per
// triangle with the depth `thickness` (m) behind it. Prisms of adjacent triangles meet in the
// bisecting plane as an internal face through the common edge, so that each contact normal belongs
// to exactly one part (ConvexPart), and a flat edge has no effect. Free edges are square ends.
// Edges of more than two triangles, and edges too sharp for a bisecting plane, count as free.
// Throws InputError for triangles without area, duplicate triangles and adjacent triangles of
// opposite orientation.
std::vector<ConvexPart> wall_solids(const TriangleMesh& mesh, double thickness);

// A box centered at the origin with the edge lengths `size` (m).
std::vector<HalfSpace> box_half_spaces(const Vec3& size);

}  // namespace firn
