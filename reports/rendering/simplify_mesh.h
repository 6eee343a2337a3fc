// Fewer triangles for drawing.
#pragma once

#include <cstddef>

#include "firn/mesh.h"

namespace firn {

// About `wanted` triangles of the same surface, by edge collapses with quadric error metrics
// (meshoptimizer). The vertices are a subset of those of `mesh`; closed meshes stay closed, and
// free edges keep their shape. More than `wanted` where fewer would fold the surface.
TriangleMesh simplified_mesh(const TriangleMesh& mesh, std::size_t wanted);

}  // namespace firn
