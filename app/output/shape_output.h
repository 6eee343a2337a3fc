// Properties of a shape as text and JSON.
#pragma once

#include <string>

#include "app/output/response_output.h"
#include "firn/mesh_conflicts.h"
#include "firn/shape.h"

namespace firn {

// One line: bounding box, mass, parts, triangles, L and stiffness.
std::string shape_line(const Shape& shape);
// A paragraph, one fact a line.
std::string shape_table(const Shape& shape);
Json shape_json(const Shape& shape);

// "none" when there are neither.
std::string defects_text(const MeshDefects& defects, const MeshConflicts& conflicts);
Json defects_json(const MeshDefects& defects, const MeshConflicts& conflicts);

}  // namespace firn
