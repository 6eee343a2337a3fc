// Tables made once from the model, and scratch memory of a step. Only the loads of a deferred half
// kick (see Solver::step()) are read by the next step. That half kick is completed before a state
// is saved, so a restored state may use a new workspace.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "firn/rigid_motion.h"
#include "solver/collision/broadphase.h"
#include "solver/contact/contact_law_batch.h"
#include "solver/contact/patch_builder.h"
#include "solver/core/parallel.h"
#include "solver/dynamics/free_body.h"
#include "solver/dynamics/mechanism.h"
#include "solver/dynamics/rigid_body.h"
#include "solver/state/bond_workspace.h"
#include "solver/state/contact_statistics_workspace.h"
#include "solver/state/neighbor_list_arrays.h"
#include "solver/state/neighbor_list_pieces.h"
#include "solver/state/state.h"

namespace firn {

// A pair whose contacts must be searched in this step.
struct PairToTest {
  std::uint32_t pair = 0;
  double translation_bound = 0;  // m, sum of both bodies
  double moved = 0;              // m, see PairMotionBound
  Pose pose;                     // b in a
};

// Result of one contact search.
struct ContactSearchResult {
  int queries = 0;
  int late_contacts = 0;
  bool tunneled = false;           // parts have passed through each other
  double initial_penetration = 0;  // m, overlap of bodies that were placed into each other
  PatchBuffer found;
};

// Sums of a step over the contacts of one range of pairs. The ranges do not depend on the number of
// threads and are added in order, so the sums are bit-identical.
struct ContactTotals {
  struct Wall {
    Vec3 impulse = Vec3::Zero(), angular_impulse = Vec3::Zero();  // N s, N m s, on the boundary
    double peak = 0;                                              // N
    bool touched = false;
  };
  double work_normal = 0, work_friction = 0, work_boundaries = 0, boundary_work = 0;  // J
  double largest_overlap = 0;                                                         // m
  std::int32_t largest_overlap_particle = -1;
  double beyond_limit = 0, limit = 0;  // m, the first overlap beyond its limit; 0: none
  std::int32_t beyond_limit_a = -1, beyond_limit_b = -1;  // bodies
  std::vector<Wall> walls;                                // [boundaries]
  std::vector<std::int32_t> touched;                      // [of walls] indices that were touched
};

// A pair that may have passed through each other or was inserted overlapping.
struct ContactFault {
  std::uint32_t pair;
  bool tunneled;
  double initial_penetration;  // m
};

// Load of the patches of one range of pairs on one of its bodies. Each member is one wide load.
struct alignas(64) BlockLoad {
  Vec4 force{};   // N; fourth: largest normal force of a patch
  Vec4 torque{};  // N m
};

// A range of kPairsPerBlock listed pairs, the unit of work of a task. Pairs are sorted along a
// space-filling curve, so that a range has few bodies.
inline constexpr std::size_t kPairsPerBlock = 1024;
struct alignas(64) PairBlock {
  std::vector<std::int32_t> bodies;                  // in order of their first pair
  std::vector<std::array<std::uint16_t, 2>> locals;  // [pairs of the range] into bodies
  std::size_t first_load = 0;                        // of bodies, in Workspace::loads
  std::vector<ActivePair> active;                    // ascending
  bool active_is_stale = true;
  // Of the present step:
  std::vector<ActivePair> refreshed;  // pairs whose patches were rebuilt, ascending; may have
                                      // none left; places are those before holes are closed
  std::vector<std::uint32_t>
      overflowed;                  // of them, those whose patches do not fit into their place,
  std::vector<PatchBuffer> found;  // and these patches; may be longer
  std::vector<ContactFault> contact_faults;
  std::uint64_t queries = 0, contact_searches = 0, late_contacts = 0;
  std::int64_t more_patches = 0, more_points = 0;  // than before
  ContactTotals accounts;
  RangeStatistics notes;  // empty without statistics
};

// Scratch memory of a task, reused for all of its ranges so that it stays in the cache. Aligned,
// because adjacent elements belong to other threads.
struct alignas(64) TaskScratch {
  std::vector<std::uint32_t> due, next_due;  // pairs to test, of a range and of the next one
  std::vector<PairToTest> searched;          // pairs among `due` whose contacts are searched
  std::vector<std::uint32_t> due_parts;      // of the pair that is searched
  std::vector<PartContact> contacts;
  PatchScratch patches;
  ContactSearchResult search;
  std::vector<ActivePair> active;
};

inline ActivePair active_pair(const PairBlock& range, const State& s, std::uint32_t p) {
  const Pair& pair = s.pairs[p];
  const auto [local_a, local_b] = range.locals[p % kPairsPerBlock];
  return {p,      pair.first_patch, pair.patch_count, pair.first_point, pair.a,
          pair.b, pair.law,         local_a,          local_b};
}

// Index of the loads of each particle, in order of the ranges that have the particle.
struct LoadIndex {
  HugePageVector<std::uint32_t> first;  // [particles + 1] into:
  HugePageVector<std::uint32_t> loads;  // into Workspace::loads
};

// Geometry of a boundary contact for the contact search.
struct BoundaryContactTable {
  PairCoefficients law;
  std::vector<ConvexPart> parts_a, parts_b;  // with rounded edges; b: empty for a plane
  std::vector<std::uint64_t> connected;      // [parts of a], every part with every part
  FlatSurfaces surfaces_a, surfaces_b;
  double reach_a = 0;  // m, of a, from its origin
  // Bounding sphere of the smaller boundary in its own axes: bounds the relative motion.
  bool smaller_is_a = true;
  Vec3 center = Vec3::Zero();  // m
  double radius = 0;           // m
};

// Scratch memory for the boundary or frame that is being moved, reused in every step.
struct BoundaryMotionScratch {
  std::vector<const Motion*> motions;  // of the model and of stages
  std::vector<RigidMotion> carried;    // [motions] displacement by the motions before each
  std::array<std::vector<const Motor*>, kMaxJoints> motors;  // [axes] of a free body
  std::vector<BoundedPush> pushes;                           // of a free body
  std::vector<FrameMotion> frames;                           // at the start of the step
  std::vector<BodyLoad> loads;  // [frames] on the bodies of mechanisms then
  bool unconverged = false;     // a half-kick of a mechanism in this step; see MechanismKick
};

struct Workspace {
  // `threads`: 0 selects the number of the model.
  explicit Workspace(const Model& model, int threads = 0);

  int threads;
  std::vector<RigidBody> rigid;                // [shapes]
  std::vector<PairCoefficients> laws;          // [shape * (shapes + boundaries) + other]
  std::vector<std::optional<AabbTree>> trees;  // [boundaries]; none for planes
  std::vector<FlatSurfaces> surfaces;          // [shapes + boundaries]
  std::vector<double> reach;          // [shapes + boundaries] m, farthest point from the center
  std::vector<double> thinnest;       // [shapes + boundaries] m, least thickness of a part
  std::vector<double> smallest_part;  // [shapes] m, least bounding radius of a part
  double skin = 0;                    // m
  double least_overlap_limit = 0;     // m, over all laws

  // A new list is found in chunks and written here while the old one is read. Then both are
  // swapped.
  std::vector<NeighborListChunk> list_chunks;
  NeighborListBuffers back_buffer;

  // Rebuilt with the neighbor list:
  bool neighbor_list_rebuilt = true;
  std::vector<PairBlock> ranges;
  std::size_t blocks_per_task = 1;
  std::vector<TaskScratch> scratch;      // [tasks]
  std::int64_t patches = 0, points = 0;  // in use; the arrays of State also have unused elements
  bool points_moved = false;             // holes were closed in this step
  HugePageVector<BlockLoad> loads;       // of all ranges, concatenated
  LoadIndex load_index;
  TaskAffinity pair_shares, body_shares;  // of tasks: ranges of pairs, and of bodies
  std::vector<char> needs_rebuild;        // [tasks] a body has moved further than its skin

  BondWorkspace bonds;
  StatisticsWorkspace statistics;

  BoundaryMotionScratch boundary_motion;
  std::vector<Mechanism> mechanisms;
  std::vector<int> mechanism_of;                        // [frames] -1: none
  std::vector<BoundaryContactTable> boundary_contacts;  // [boundary contacts of the model]
  TaskScratch boundary_scratch;
  // Written by a step while those of the state are read. Then both are swapped.
  std::vector<ContactPatch> boundary_patches;
  std::vector<ContactPoint> boundary_points;
  std::vector<PatchDetail> boundary_details;  // zero: boundaries have no rolling resistance

  int law_index(int shape_a, int shape_b) const { return shape_a * columns + shape_b; }
  int law_index_boundary(int shape_a, int boundary) const {
    return shape_a * columns + shapes + boundary;
  }
  int shapes = 0, columns = 0;
};

// After a new neighbor list: finds the ranges of pairs and their bodies.
void build_pair_blocks(const Model& model, Workspace& workspace, const State& state);

// "particle 3" or "boundary "floor"".
std::string name_of_body(const Model& model, int body);

// Body axes -> world. Computed on demand: few callers need it.
inline Mat3 rotation_of(const State& s, int body) { return s.orientation[body].toRotationMatrix(); }

// Pose of b's axes in a's axes.
inline Pose relative_pose(const State& s, int a, int b) {
  Pose p;
  const Mat3 at = rotation_of(s, a).transpose();
  p.rotation = at * rotation_of(s, b);
  p.translation = at * (s.motion[b].position - s.motion[a].position);
  return p;
}

}  // namespace firn
