// From the manifolds of a body pair's parts to its patches, with the memory of the last ones.
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "solver/collision/narrowphase.h"
#include "solver/contact/contact_law.h"

namespace firn {

// Of a part in a mask of parts; parts share bits beyond 64.
inline std::uint64_t part_bit(int part) { return std::uint64_t{1} << (part & 63); }

// What one touching pair of parts gave, in axes of body a.
struct PartContact {
  int a = 0, b = 0;                        // parts
  std::uint64_t other_a = 0, other_b = 0;  // masks of further parts whose contact this is, too
  Manifold manifold;
};

struct PatchInput {
  const PairLaw& law;
  const Mat3& rotation_a;  // body a's axes -> world
  std::span<const PartContact> contacts;
  std::span<const std::uint64_t> neighbours_a;  // [parts of a] masks of touching parts
  std::span<const std::uint64_t> neighbours_b;  // empty: a boundary, all parts are connected
  std::span<const Patch> old_patches;           // of the same pair
  const PatchDetail* old_details = nullptr;     // of them; and their point indices go into:
  const ContactPoint* old_points = nullptr;
  // Of a against b, world, as over the step that ends with these contacts.
  Vec3 velocity = Vec3::Zero();         // m/s, of the material of both at the centre of a
  Vec3 velocity_before = Vec3::Zero();  // the same, with the lever of b of before the step
  Vec3 spin = Vec3::Zero();             // rad/s
  double dt = 0;                        // s
};

// The point of an old patch that is nearest to a new point.
struct PointMatch {
  double distance2 = std::numeric_limits<double>::infinity();  // m^2
  double part = 1;                // of the loading line K s that it bears
  double stiffness_fraction = 0;  // of the stiffness; 0: it is elsewhere, or bears next to nothing
  double overlap = 0;             // m, of the new point before the approach of this step
};

// A pair's patches and points as found at one refresh, before they are stored.
struct FoundPatches {
  std::vector<Patch> patches;
  std::vector<PatchDetail> details;  // [patches]
  std::vector<ContactPoint> points;
  void clear() {
    patches.clear();
    details.clear();
    points.clear();
  }
};

// Scratch memory that keeps its capacity from call to call.
struct PatchScratch {
  std::vector<int> group;
  std::vector<PointMatch> matches;  // [points]
  std::vector<double> capacity;     // [patches] for one old patch
  std::vector<double> energy;       // J [patches], recoverable, from old patches
  std::vector<double> work;         // J [patches], of the old forces in this step
  std::vector<int> stack;
  std::vector<ManifoldPoint> hull;
  std::vector<char> has_parent;
};

// Fills `out` with patches whose point indices count from 0. Returns how many were born deep:
// without a parent and already overlapping by more than law.late_overlap.
int build_patches(const PatchInput& input, PatchScratch& scratch, FoundPatches& out);

}  // namespace firn
