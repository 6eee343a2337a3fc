// Vectors and turns thrown at random.
#pragma once

#include "validation/verification/fixtures/scenes.h"

namespace firn {

inline Vec3 random_vector(scenes::Random& random, double size) {
  return {random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)};
}

struct Dice {
  explicit Dice(std::uint64_t seed) : random(seed) {}
  double operator()(double low, double high) { return random.uniform(low, high); }
  Vec3 vector(double size) { return random_vector(random, size); }
  Quat turn() { return random.orientation(); }

  scenes::Random random;
};

}  // namespace firn
