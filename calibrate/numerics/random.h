// Random numbers that are the same on every machine: the standard distributions differ between
// libraries.
#pragma once

#include <random>

namespace firn {

// Uniform in (0, 1).
inline double uniform(std::mt19937_64& random) {
  return (static_cast<double>(random() >> 11) + 0.5) * 0x1p-53;
}

}  // namespace firn
