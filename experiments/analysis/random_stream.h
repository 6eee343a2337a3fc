// Random numbers that are the same everywhere.
#pragma once

#include <cstdint>
#include <random>

#include "firn/math.h"

namespace firn {

// Random numbers of one batch: one stream for each (seed, fill, batch). A checkpoint therefore
// needs no state of a generator.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::uint64_t fill, std::uint64_t batch);
  double uniform();         // [0, 1), 53 random bits
  Quat uniform_rotation();  // Shoemake, Graphics Gems III (1992), III.6

 private:
  std::mt19937_64 engine_;
};

}  // namespace firn
