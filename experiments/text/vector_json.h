// Numbers and vectors in JSON.
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>

#include "firn/math.h"

namespace firn {

// null for a number that is not finite.
inline nlohmann::ordered_json number_json(double x) {
  return std::isfinite(x) ? nlohmann::ordered_json(x) : nlohmann::ordered_json();
}

// [x, y, z]
inline nlohmann::ordered_json vector_json(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace firn
