// Buffers for a new neighbor list, written while the arrays of the state are still read.
#pragma once

#include <algorithm>

#include "solver/state/state.h"

namespace firn {

struct NeighborListBuffers {
  HugePageVector<Pair> pairs;
  HugePageVector<double> next_test_distance;
  HugePageVector<PairMotionBound> motion_bound;
  HugePageVector<PartPair> part_pairs;
  HugePageVector<ContactPatch> patches;
  HugePageVector<PatchDetail> patch_details;
  HugePageVector<ContactPoint> points;
};

// Copies the patches and points of a pair of `s` to `to`, from index `patches` and `points` on.
// Advances both indices past the copies and stores the new positions in `pair`. `old` may be
// `pair`.
inline void copy_contacts(const State& s, const Pair& old, Pair& pair, NeighborListBuffers& to,
                          std::size_t& patches, std::size_t& points) {
  const std::uint32_t first = old.first_patch;
  pair.patch_count = pair.patch_capacity = old.patch_count;
  pair.first_patch = pair.first_point = pair.point_capacity = 0;
  if (pair.patch_count == 0) return;
  pair.first_patch = static_cast<std::uint32_t>(patches);
  pair.first_point = static_cast<std::uint32_t>(points);
  for (std::uint32_t k = 0; k < pair.patch_count; ++k) {
    ContactPatch& patch = to.patches[patches];
    patch = s.patches[first + k];
    to.patch_details[patches++] = s.patch_details[first + k];
    std::copy_n(s.points.begin() + patch.first_point, patch.point_count,
                to.points.begin() + static_cast<std::ptrdiff_t>(points));
    patch.first_point = static_cast<std::uint32_t>(points);
    points += patch.point_count;
  }
  pair.point_capacity = static_cast<std::uint32_t>(points) - pair.first_point;
}

}  // namespace firn
