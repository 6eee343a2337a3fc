// Vectors and turns thrown at random.
#pragma once

#include "validation/verification/fixtures/scenes.h"

namespace firn {

struct Dice {
  explicit Dice(std::uint64_t seed) : random(seed) {}
  double operator()(double low, double high) { return random.uniform(low, high); }
  Vec3 vector(double size) {
    return {(*this)(-size, size), (*this)(-size, size), (*this)(-size, size)};
  }
  Quat turn() { return random.orientation(); }

  scenes::Random random;
};

}  // namespace firn
