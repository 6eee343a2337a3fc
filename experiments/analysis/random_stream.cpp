#include "experiments/analysis/random_stream.h"

#include <cmath>
#include <numbers>

namespace firn {

RandomStream::RandomStream(std::uint64_t seed, std::uint64_t fill, std::uint64_t batch) {
  const auto low = [](std::uint64_t x) { return static_cast<std::uint32_t>(x); };
  const auto high = [](std::uint64_t x) { return static_cast<std::uint32_t>(x >> 32); };
  std::seed_seq words{low(seed), high(seed), low(fill), high(fill), low(batch), high(batch)};
  engine_.seed(words);
}

Quat RandomStream::uniform_rotation() {
  const double u = uniform(), a = 2 * std::numbers::pi * uniform(),
               b = 2 * std::numbers::pi * uniform();
  const double s = std::sqrt(1 - u), c = std::sqrt(u);
  return Quat(c * std::cos(b), s * std::sin(a), s * std::cos(a), c * std::sin(b)).normalized();
}

}  // namespace firn
