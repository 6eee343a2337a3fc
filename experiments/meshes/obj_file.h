// Wavefront OBJ files.
#pragma once

#include <cstddef>
#include <string>

#include "firn/mesh.h"

namespace firn {

// The faces of all objects as triangles, in the unit of the file. Polygons are triangulated.
// Textures, normals, groups and materials are ignored. `file`: name in messages. Throws InputError
// `FILE:LINE: ...` for a vertex without three finite coordinates, for an invalid face, a face with
// more than 1000 corners or with an unknown vertex, and for more than `limit` triangles.
TriangleMesh read_obj(const std::string& file, const std::string& bytes,
                      std::size_t limit = 200000);

}  // namespace firn
