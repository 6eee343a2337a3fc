// From the manifolds of a body pair's parts to its patches, with the memory of the last ones.
#pragma once

#include <span>
#include <vector>

#include "solver/collide.h"
#include "solver/contact.h"

namespace firn {

// What one touching pair of parts gave, in axes of body a.
struct PartContact {
  int a = 0, b = 0;  // parts
  Manifold manifold;
};

struct PatchInput {
  const PairLaw& law;
  const Mat3& rotation_a;  // body a's axes -> world
  std::span<const PartContact> contacts;
  std::span<const std::uint64_t> neighbours_a;  // [parts of a] masks of touching parts
  std::span<const std::uint64_t> neighbours_b;  // empty: a boundary, all parts are connected
  std::span<const Patch> old_patches;           // of the same pair
  const Vec3* old_rolling = nullptr;            // of them; and their point indices go into:
  const ContactPoint* old_points = nullptr;
};

// A pair's patches and points as found at one refresh, before they are stored.
struct FoundPatches {
  std::vector<Patch> patches;
  std::vector<Vec3> rolling;  // [patches]
  std::vector<ContactPoint> points;
  void clear() {
    patches.clear();
    rolling.clear();
    points.clear();
  }
};

// Scratch memory that keeps its capacity from call to call.
struct PatchScratch {
  std::vector<int> group;
  std::vector<double> density;  // N, of each point of a patch
  std::vector<char> is_new;     // [points] the old patch had none there
  std::vector<int> stack;
  std::vector<ManifoldPoint> hull;
  std::vector<char> has_parent;
};

// Fills `out` with patches whose point indices count from 0. Returns how many were born deep:
// without a parent and already overlapping by more than law.deep.
int build_patches(const PatchInput& input, PatchScratch& scratch, FoundPatches& out);

}  // namespace firn
