// Storage of the patches and points of all pairs in the arrays of the state. Each pair has a range
// of elements, which may have unused ones at its end.
#pragma once

#include <algorithm>
#include <cstdint>

#include "solver/contact/patch_builder.h"
#include "solver/state/workspace.h"

namespace firn {

// True when the result of a search does not exceed the capacity of the pair.
inline bool patches_fit(const PatchBuffer& f, const Pair& pair) {
  return f.patches.size() <= pair.patch_capacity && f.points.size() <= pair.point_capacity;
}

// Copies the result of a search into the arrays of the state, at the indices of the pair.
inline void store_patches(const PatchBuffer& f, Pair& pair, State& s) {
  const auto patches = static_cast<std::uint32_t>(f.patches.size());
  for (std::uint32_t k = 0; k < patches; ++k) {
    ContactPatch& patch = s.patches[pair.first_patch + k];
    patch = f.patches[k];
    patch.first_point += pair.first_point;
  }
  std::copy(f.details.begin(), f.details.end(), s.patch_details.begin() + pair.first_patch);
  std::copy(f.points.begin(), f.points.end(), s.points.begin() + pair.first_point);
  pair.patch_count = patches;
}

// Moves a pair whose patches or points exceed its capacity to new elements at the end of the
// arrays.
void reallocate_patches(const PatchBuffer& f, Pair& pair, State& s);

// True when too many elements of the arrays are unused.
bool needs_compaction(const Workspace& w, const State& s);
// Removes the holes in the arrays. A pair leaves a hole when it outgrows its capacity or loses its
// contacts. Every step reads all patches, and contiguous patches are read fastest.
void compact_patches(int threads, NeighborListBuffers& spare, State& s);

}  // namespace firn
