// Length units of mesh files, whose formats do not state one.
#pragma once

#include <string>

namespace firn {

enum class MeshUse { particle, boundary };

// A warning in one sentence if a mesh has an unusual size for its use and a usual one in another
// length unit; else empty. `longest_edge` (m): of the bounding box with the unit `length_unit` (m).
std::string length_unit_warning(double longest_edge, double length_unit, MeshUse use);

// Length of a unit in m by its name, "mm". Throws InputError (one sentence).
double parse_length_unit(const std::string& name);

}  // namespace firn
