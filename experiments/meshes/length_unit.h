// The unit of a mesh file, which names none.
#pragma once

#include <string>

namespace firn {

enum class MeshUse { particle, boundary };

// A sentence where a mesh with this longest edge of its bounding box (m), read in this unit (m), is
// no usual ice cube or part of an icemaker, and is one in another usual unit. Empty: none.
std::string unit_advice(double longest_edge, double length_unit, MeshUse use);

// Meters of a unit by its name, "mm". Throws InputError, one sentence.
double parse_length_unit(const std::string& name);

}  // namespace firn
