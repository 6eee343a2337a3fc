// Chunks of a new neighbor list, which tasks find in parallel before the list is written.
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

// Pairs of a range of bodies with bodies of higher number.
struct NeighborListChunk {
  std::vector<CandidatePair> pairs;
  std::vector<PartNumbers> parts;  // of all pairs, concatenated
  ListSizes size, first;           // where it begins in the list

  // Removes the content and keeps the memory, which the operating system would otherwise clear
  // again.
  void clear() {
    pairs.clear();
    parts.clear();
  }
};

}  // namespace firn
