// Wavefront OBJ files.
#pragma once

#include <cstddef>
#include <string>

#include "firn/mesh.h"

namespace firn {

// The faces of all objects as triangles, in the file's unit; polygons are cut up. Texture, normals,
// groups and materials are left alone. `file` names it in messages.
// Throws InputError `FILE:LINE: ...` for a vertex that is not three finite numbers and for a face
// that is none, has more than 1000 corners or names a vertex that is not there; and as soon as
// there are more than `limit` triangles.
TriangleMesh read_obj(const std::string& file, const std::string& bytes,
                      std::size_t limit = 200000);

}  // namespace firn
