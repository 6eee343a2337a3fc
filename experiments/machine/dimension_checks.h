// Checks of the dimensions of machine parts.
#pragma once

#include <fmt/format.h>

#include <string>

#include "experiments/machine/swept_solid.h"

namespace firn {

// Throws DimensionError "KEY MESSAGE" unless `holds`.
inline void require(bool holds, const char* key, const std::string& message) {
  if (!holds) throw DimensionError(key, message);
}

inline void require_above_zero(double value, const char* key) {
  require(value > 0, key, "is not above zero; expected more");
}

inline std::string in_mm(double length) { return fmt::format("{:.6g} mm", 1e3 * length); }
inline std::string in_degrees(double angle) { return fmt::format("{:.6g} deg", angle * kRadToDeg); }

}  // namespace firn
