// Wavefront OBJ files.
#pragma once

#include <string>

#include "solver/mesh.h"

namespace firn {

// The faces of all objects as triangles, in the file's unit; polygons are cut up. Texture, normals,
// groups and materials are left alone. `file` names it in messages.
// Throws InputError `FILE:LINE: ...` for a vertex that is not three finite numbers and for a face
// that is none, or names a vertex that is not there.
TriangleMesh read_obj(const std::string& file, const std::string& bytes);

}  // namespace firn
