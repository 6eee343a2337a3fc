// Random numbers that are equal on every machine. The distributions of the standard library differ
// between implementations.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <random>

#include "firn/math.h"

namespace firn {

// Uniform in [0, 1): 53 random bits.
inline double uniform_half_open(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1p-53;
}

// Uniform in (0, 1), so that the logarithm is finite.
inline double uniform_open(std::mt19937_64& random) {
  return (static_cast<double>(random() >> 11) + 0.5) * 0x1p-53;
}

// Integers in 0 ... count - 1. The two functions give different numbers from the same generator.
// Designs of studies are drawn by the first, screenings by the second.
inline std::size_t random_below_by_remainder(std::mt19937_64& random, std::size_t count) {
  return random() % count;
}
inline std::size_t random_below_by_scaling(std::mt19937_64& random, std::size_t count) {
  return static_cast<std::size_t>(uniform_half_open(random) * static_cast<double>(count));
}

// Standard normal deviate (Box and Muller 1958).
inline double normal_deviate(std::mt19937_64& random) {
  const double radius = std::sqrt(-2 * std::log(uniform_open(random)));
  return radius * std::cos(2 * std::numbers::pi * uniform_open(random));
}
// The same from the numbers of uniform_half_open(), which gives other numbers from the same
// generator. Studies draw by the first, errors of photographs by the second.
inline double normal_deviate_half_open(std::mt19937_64& random) {
  const double u = uniform_half_open(random), v = uniform_half_open(random);
  return std::sqrt(-2 * std::log(1 - u)) * std::cos(2 * std::numbers::pi * v);
}

// Random numbers of one batch of particles. Each (seed, fill, batch) has a separate stream, so that
// checkpoints need no generator state.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::uint64_t fill, std::uint64_t batch);
  double uniform() { return uniform_half_open(engine_); }  // [0, 1)
  Quat uniform_rotation();  // uniform over all rotations: Shoemake, Graphics Gems III (1992), III.6

 private:
  std::mt19937_64 engine_;
};

}  // namespace firn
