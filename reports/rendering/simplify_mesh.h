// Fewer triangles for drawing.
#pragma once

#include <cstddef>

#include "firn/mesh.h"

namespace firn {

// About `wanted` triangles of the same surface, by quadric error metrics (Garland and Heckbert
// 1997); a corner is moved onto its neighbor, so that all that are left are corners of the mesh
// given. Keeps free edges where they are. More than wanted where fewer would fold the surface.
TriangleMesh simplified_mesh(const TriangleMesh& mesh, std::size_t wanted);

}  // namespace firn
