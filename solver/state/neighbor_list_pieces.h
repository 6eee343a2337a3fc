// Stretches of a new neighbour list, as they are found side by side before the list is written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace firn {

// A part of one body and a part of another.
struct PartNumbers {
  std::uint32_t a, b;
};

// A pair of the new list.
struct CandidatePair {
  static constexpr std::uint32_t kNew = ~std::uint32_t{0};
  std::int32_t a, b, law;
  std::uint32_t old;  // its number in the old list, or kNew
  std::uint32_t part_count;
};

struct ListSizes {
  std::size_t pairs = 0, parts = 0, patches = 0, points = 0;
  void add(const ListSizes& o) {
    pairs += o.pairs;
    parts += o.parts;
    patches += o.patches;
    points += o.points;
  }
};

// The pairs of some bodies with later ones.
struct NeighborListChunk {
  std::vector<CandidatePair> pairs;
  std::vector<PartNumbers> parts;  // of all pairs, one behind the other
  ListSizes size, first;           // where it begins in the list

  // For new pairs; keeps the memory, which the system would have to clear again.
  void clear() {
    pairs.clear();
    parts.clear();
  }
};

}  // namespace firn
