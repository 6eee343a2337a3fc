#pragma once

#include <nlohmann/json.hpp>

#include "firn/math.h"

namespace firn {

// [x, y, z]
inline nlohmann::ordered_json vector_json(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace firn
