// Builds the patches of a body pair from the manifolds of its parts, with the history of the
// previous patches.
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "solver/collision/narrowphase.h"
#include "solver/contact/contact_law.h"

namespace firn {

// Bit of a part in a mask of parts. Parts with a number above 63 share bits.
inline std::uint64_t part_bit(int part) { return std::uint64_t{1} << (part & 63); }

// Contact of one touching pair of parts, in axes of body a.
struct PartContact {
  int a = 0, b = 0;                        // parts
  std::uint64_t other_a = 0, other_b = 0;  // masks of further parts to which this contact belongs
  double radius_a = 0, radius_b = 0;       // m, sweep radii of the parts
  Manifold manifold;
};

struct PatchInput {
  const PairCoefficients& law;
  const Mat3& rotation_a;  // body a's axes -> world
  std::span<const PartContact> contacts;
  std::span<const std::uint64_t> neighbors_a;  // [parts of a] masks of touching parts
  std::span<const std::uint64_t> neighbors_b;  // empty: a boundary, all parts are connected
  std::span<const ContactPatch> old_patches;   // of the same pair
  const PatchDetail* old_details = nullptr;    // [old_patches]; their point indices refer to:
  const ContactPoint* old_points = nullptr;
  // Relative motion of a and b (a minus b), world axes, over the step that ends with these
  // contacts.
  Vec3 velocity = Vec3::Zero();          // m/s, of the material points of both at the center of a
  Vec3 velocity_before = Vec3::Zero();   // the same, with the lever arm of b before the step
  Vec3 angular_velocity = Vec3::Zero();  // rad/s
  double dt = 0;                         // s
};

// The point of an old patch that is nearest to a new point.
struct PointMatch {
  double distance2 = std::numeric_limits<double>::infinity();  // m^2
  double part = 1;                // force of the point over K s, the loading line
  double stiffness_fraction = 0;  // of the stiffness; 0: no match, or almost unloaded
  double overlap = 0;             // m, of the new point before the approach of this step
};

// Patches and points of a pair found by one contact search, before they are stored.
struct PatchBuffer {
  std::vector<ContactPatch> patches;
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

// Fills `out` with patches whose point indices count from 0. Returns the number of late contacts:
// patches without a parent whose overlap exceeds law.late_overlap.
int build_patches(const PatchInput& input, PatchScratch& scratch, PatchBuffer& out);

}  // namespace firn
