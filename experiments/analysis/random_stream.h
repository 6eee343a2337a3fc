// Random numbers that are the same on every machine: the standard distributions differ between
// libraries.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

#include "firn/math.h"

namespace firn {

// Uniform in [0, 1): 53 random bits.
inline double half_open_uniform(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1p-53;
}

// Uniform in (0, 1): its logarithm is finite.
inline double open_uniform(std::mt19937_64& random) {
  return (static_cast<double>(random() >> 11) + 0.5) * 0x1p-53;
}

// Standard normal deviate (Box and Muller 1958).
inline double normal_deviate(std::mt19937_64& random) {
  const double radius = std::sqrt(-2 * std::log(open_uniform(random)));
  return radius * std::cos(2 * std::numbers::pi * open_uniform(random));
}

// Random numbers of one batch: one stream for each (seed, fill, batch). A checkpoint therefore
// needs no state of a generator.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::uint64_t fill, std::uint64_t batch);
  double uniform() { return half_open_uniform(engine_); }  // [0, 1)
  Quat uniform_rotation();  // Shoemake, Graphics Gems III (1992), III.6

 private:
  std::mt19937_64 engine_;
};

}  // namespace firn
