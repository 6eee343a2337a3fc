// Solids for walls, made of convex parts without contacts at their internal faces.
#pragma once

#include <vector>

#include "firn/convex_part.h"
#include "firn/mesh.h"

namespace firn {

// A surface as solids behind its triangles. A closed one that faces inwards is a container. A
// closed convex mesh is one part. Any other, open or closed, becomes one thin prism a triangle,
// `thickness` (m) deep behind the face. Where two triangles meet, their prisms meet in the plane
// that bisects them, as an internal face: it passes through the shared edge, so the seam rule of
// ConvexPart gives each contact normal to exactly one side, and a flat seam is no feature at all.
// Free edges are real, square ones. Edges of more than two triangles, and folds so sharp that a
// bisector would cut the sheet away, count as free. Throws InputError for triangles of no area,
// duplicates or neighbours that face opposite ways.
std::vector<ConvexPart> boundary_parts(const TriangleMesh& mesh, double thickness);

// A box about the origin, edges `size` (m).
std::vector<HalfSpace> box_half_spaces(const Vec3& size);

}  // namespace firn
