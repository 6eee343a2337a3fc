#include "solver/contact_detection/patch_storage.h"

#include <cstddef>
#include <utility>
#include <vector>

#include "solver/core/parallel.h"

namespace firn {

void reallocate_patches(const PatchBuffer& f, Pair& pair, State& s) {
  const auto patches = static_cast<std::uint32_t>(f.patches.size());
  const auto points = static_cast<std::uint32_t>(f.points.size());
  if (patches > pair.patch_capacity) {
    pair.first_patch = static_cast<std::uint32_t>(s.patches.size());
    pair.patch_capacity = std::max(patches, 2u);
    s.patches.resize(s.patches.size() + pair.patch_capacity);
    s.patch_details.resize(s.patches.size());
  }
  if (points > pair.point_capacity) {
    pair.first_point = static_cast<std::uint32_t>(s.points.size());
    pair.point_capacity = std::max(points, 6u);
    s.points.resize(s.points.size() + pair.point_capacity);
  }
}

bool needs_compaction(const Workspace& w, const State& s) {
  constexpr std::size_t kFew = 1000;  // unused elements that are always accepted
  return s.patches.size() > static_cast<std::size_t>(w.patches + w.patches / 2) + kFew ||
         s.points.size() > static_cast<std::size_t>(w.points + w.points / 2) + 2 * kFew;
}

void compact_patches(int threads, NeighborListBuffers& spare, State& s) {
  struct Sizes {
    std::size_t patches = 0, points = 0;
  };
  const std::size_t pairs = s.pairs.size(), ranges = (pairs + kPairsPerBlock - 1) / kPairsPerBlock;
  std::vector<Sizes> first(ranges + 1);
  parallel_for_blocks(threads, pairs, kPairsPerBlock, [&](std::size_t begin, std::size_t end) {
    Sizes& size = first[begin / kPairsPerBlock + 1];
    for (std::size_t p = begin; p < end; ++p) {
      size.patches += s.pairs[p].patch_count;
      size.points += static_cast<std::size_t>(points_of(s.pairs[p], s));
    }
  });
  for (std::size_t r = 0; r < ranges; ++r) {
    first[r + 1].patches += first[r].patches;
    first[r + 1].points += first[r].points;
  }
  resize_discarding(spare.patches, first.back().patches);
  resize_discarding(spare.patch_details, first.back().patches);
  resize_discarding(spare.points, first.back().points);
  parallel_for_blocks(threads, pairs, kPairsPerBlock, [&](std::size_t begin, std::size_t end) {
    Sizes at = first[begin / kPairsPerBlock];
    for (std::size_t p = begin; p < end; ++p)
      copy_contacts(s, s.pairs[p], s.pairs[p], spare, at.patches, at.points);
  });
  std::swap(s.patches, spare.patches);
  std::swap(s.patch_details, spare.patch_details);
  std::swap(s.points, spare.points);
}

}  // namespace firn
