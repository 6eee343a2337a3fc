// Random orders that are the same on every machine.
#pragma once

#include <cstdint>
#include <random>
#include <utility>
#include <vector>

namespace firn {

class RandomOrder {
 public:
  // A random integer from 0 to `limit` - 1, without bias.
  std::size_t below(std::size_t limit) {
    const std::uint64_t most = std::mt19937_64::max() - std::mt19937_64::max() % limit;
    std::uint64_t r = bits_();
    while (r >= most) r = bits_();
    return static_cast<std::size_t>(r % limit);
  }
  template <class T>
  void shuffle(std::vector<T>& values) {
    for (std::size_t i = values.size(); i > 1; --i) std::swap(values[i - 1], values[below(i)]);
  }

 private:
  std::mt19937_64 bits_{20260101};
};

}  // namespace firn
