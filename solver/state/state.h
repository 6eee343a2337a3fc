// The mutable state of a simulation: every byte that the next step reads.
//
// Bodies are numbered particles first, then boundaries. Arrays by quantity; sizes in brackets:
// N particles, B boundaries, M = N + B bodies, P listed pairs.
#pragma once

#include <vector>

#include "firn/body_state.h"
#include "firn/diagnostics.h"
#include "solver/collision/narrowphase.h"
#include "solver/contact/contact_law.h"
#include "solver/core/huge_page_vector.h"
#include "solver/state/contact_statistics_state.h"

namespace firn {

// BodyMotion and BodyLoad are padded so that a vector and a zero are one wide load.
struct alignas(32) BodyMotion {
  Vec3 position = Vec3::Zero();  // m, center of mass (a boundary: its origin), world
  double zero_0 = 0;
  Vec3 velocity = Vec3::Zero();  // m/s
  double zero_1 = 0;
  Vec3 angular_velocity = Vec3::Zero();  // rad/s, world
  double zero_2 = 0;
};
struct alignas(32) BodyLoad {
  Vec3 force = Vec3::Zero();  // N, world
  double zero_0 = 0;
  Vec3 torque = Vec3::Zero();  // N m, about the center of mass, world
  double zero_1 = 0;
};

// Pose and velocity of a frame, and the joint coordinates of a free one. All members have the same
// alignment.
struct FrameMotion {
  Vec3 position = Vec3::Zero();                      // m, of the origin, world
  double rotation[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};  // frame -> world, column by column
  Vec3 velocity = Vec3::Zero();                      // m/s, of the origin, over the last step
  Vec3 angular_velocity = Vec3::Zero();              // rad/s, world
  Vec3 velocity_change = Vec3::Zero();  // changes of both velocities since the previous step
  Vec3 angular_velocity_change = Vec3::Zero();
  Vec3 impulse = Vec3::Zero();                  // N s, by contacts since the last clearing
  Vec3 angular_impulse = Vec3::Zero();          // N m s, about the moving origin
  double coordinate[kMaxJoints] = {};           // m or rad, of the axes
  double rate[kMaxJoints] = {};                 // m/s or rad/s; the last three of a body that turns
                                                // freely: its angular velocity relative to the
                                                // parent, in the parent's axes
  double motor_impulse[kMaxJoints] = {};        // N s or N m s, by motors
  double limit_impulse[kMaxJoints] = {};        // and by hard stops, both since they were cleared
  double dissipated_friction[kMaxJoints] = {};  // J, since the start
  double driven = 0;                            // 1: a motor acted in the last step
};

// Two bodies that may touch before the neighbor list is rebuilt.
struct Pair {
  std::int32_t a = 0, b = 0;     // bodies, a < b
  std::int32_t law = 0;          // index into Workspace::laws
  std::uint32_t first_part = 0;  // PartPair range
  std::uint32_t part_count = 0;
  std::uint32_t first_patch = 0;  // range of ContactPatch; the points of a pair are contiguous too
  std::uint32_t patch_count = 0;
  std::uint32_t patch_capacity = 0;
  std::uint32_t first_point = 0;
  std::uint32_t point_capacity = 0;
};

// Bound on the relative motion of a pair, which decides when its parts are tested again. `moved`
// bounds the relative displacement of any two points of the bodies up to the reference pose. Part
// pairs store their next test distance in the same measure. Aligned to two cache lines.
struct alignas(64) PairMotionBound {
  double reference_rotation[9] = {};       // b in a, column by column
  double reference_translation[3] = {};    // m
  double reference_translation_bound = 0;  // m, translation_bound[a] + translation_bound[b] then
  double reference_rotation_bound = 0;     // rad, rotation_bound[a] then
  double moved = 0;                        // m
  double test_distance = 0;                // m, the value of `moved` at which parts must be queried
};

// One convex part of a against one of b.
struct PartPair {
  double next_test_distance = 0;  // query when the pair's `moved` reaches this
  std::uint32_t b = 0;            // part of b
  std::uint16_t a = 0;            // part of a
  std::uint16_t touching = 0;     // 1: gave points at the last query
  GjkCache cache;
  std::uint16_t unused[3] = {0, 0, 0};
};

// Contact history of one boundary contact. All members have the same alignment.
struct BoundaryContactHistory {
  // Poses at the last search: of a, and of b in a; rotations column by column.
  double rotation_a[9] = {}, rotation[9] = {}, translation[3] = {};
  double test_distance = -1;  // m of relative motion at which contacts are searched again; -1: now
  double gap = 0;             // m, least, as of the last search
  Vec3 force = Vec3::Zero();  // N, on boundary a, at `time`
  Vec3 moment_a = Vec3::Zero(), moment_b = Vec3::Zero();  // N m, on each, about its origin
  Vec3 impulse = Vec3::Zero();                            // N s, since it was cleared
  double peak_normal_force = 0;                           // N, since then
  double work_normal = 0, work_friction = 0;              // J taken from the bodies
  std::uint64_t patch_count = 0, point_count = 0;
};

// Reaction in the joints of a free frame. All members have the same alignment.
struct JointReaction {
  Vec3 center_velocity = Vec3::Zero();   // m/s, of the center of mass, over the last step
  Vec3 angular_momentum = Vec3::Zero();  // kg m^2/s, about the center of mass, over the last step
  Vec3 impulse = Vec3::Zero(), angular_impulse = Vec3::Zero();  // N s, N m s, since cleared
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();             // N, N m, over the last step
  double known = 0;                                             // 1: a step has been made
};

// Point of a coupling, and its impulses on body b. All members have the same alignment.
struct CouplingReaction {
  Vec3 position = Vec3::Zero();                                 // m, world
  Vec3 impulse = Vec3::Zero(), angular_impulse = Vec3::Zero();  // N s, N m s, since cleared
  Vec3 half_impulse = Vec3::Zero(), half_angular_impulse = Vec3::Zero();  // of the last half kick
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();  // N, N m about the point, over the last step
  double dissipated_friction = 0;                    // J, since the start
};

// Work on free bodies and losses in their joints, J since the start. All members have the same
// alignment.
struct FreeBodyAccount {
  double motors = 0;    // work of motors
  double contacts = 0;  // work of all contacts on free bodies, without what contacts between
                        // boundaries do to both of their boundaries
  double carriers = 0;  // work of frames with prescribed motions through joints and couplings
  double dampers = 0, limits = 0;  // dissipated in joints
};

struct State {
  double time = 0;  // s
  std::uint64_t steps = 0;
  // Bodies
  HugePageVector<BodyMotion> motion;      // [M]
  HugePageVector<Quat> orientation;       // [M] body axes -> world
  HugePageVector<Vec3> angular_momentum;  // [N] kg m^2/s, body axes
  HugePageVector<BodyLoad> load;          // [N] by contacts and bonds, at `time`; undefined while a
                                          // half kick is pending
  HugePageVector<double> translation_bound;  // [M] m, bound on the path length of any body point
  HugePageVector<double> rotation_bound;     // [M] rad, bound on the angle of rotation
  HugePageVector<double> skin;               // [M] m, motion that the neighbor list allows
  HugePageVector<double> rebuild_distance;  // [M] m, translation bound at which the list is rebuilt
  HugePageVector<Presence> presence;        // [N]
  HugePageVector<double> peak_normal_force;                      // [N] N
  std::vector<std::uint8_t> boundary_present;                    // [B]
  std::vector<Vec3> boundary_impulse, boundary_angular_impulse;  // [B] N s, N m s
  std::vector<double> boundary_peak;                             // [B] N
  std::vector<BodyLoad> boundary_load;                           // [B] by contacts, at `time`,
                                                                 // torque about the origin
  // Motion frames. Local poses are those in the parent's axes, from the parent's origin.
  std::vector<FrameMotion> frames;             // [F]
  std::vector<Vec3> frame_position;            // [F] m, local
  std::vector<Quat> frame_orientation;         // [F] local
  std::vector<Vec3> boundary_position;         // [B] m, local; of those that a frame carries
  std::vector<Quat> boundary_orientation;      // [B]
  std::vector<JointReaction> joint_reactions;  // [F]
  std::vector<CouplingReaction> couplings;     // [couplings of the model]
  // Contacts between boundaries: patches and points, concatenated without holes.
  std::vector<BoundaryContactHistory> boundary_contacts;  // [boundary contacts of the model]
  std::vector<ContactPatch> boundary_patches;
  std::vector<ContactPoint> boundary_points;
  // Started by stages.
  std::vector<Motion> stage_motions;
  std::vector<std::int32_t> stage_motion_mover, stage_motion_group;  // a boundary, or B + frame
  std::vector<Motor> stage_motors;
  std::vector<std::int32_t> stage_motor_joint, stage_motor_group;  // frame * kMaxJoints + axis
  // Contacts
  bool neighbor_list_invalid = true;
  HugePageVector<Pair> pairs;                 // [P] along a curve through space (neighbor_list.cpp)
  HugePageVector<double> next_test_distance;  // [P] m, the pair is tested when translation_bound[a]
                                              // + translation_bound[b] reaches this
  HugePageVector<PairMotionBound> motion_bound;  // [P]
  HugePageVector<PartPair> part_pairs;
  HugePageVector<ContactPatch> patches;       // with holes
  HugePageVector<PatchDetail> patch_details;  // one for each place of a patch
  HugePageVector<ContactPoint> points;        // with holes
  std::vector<BondRecord> bonds;              // [bonds]
  std::vector<BeamLoad> bond_loads;           // [bonds] at `time`
  // Accounts
  double work_normal = 0,
         work_friction = 0;    // J taken from bodies: stored in contacts or dissipated
  double work_boundaries = 0;  // J, part of work_normal and work_friction at boundaries
  double boundary_work = 0, removed_energy = 0;  // J
  double lost_in_bonds = 0;                      // J
  FreeBodyAccount free_bodies;
  double lowest_energy = 0, largest_kinetic = 0;  // J
  bool energy_known = false;
  Diagnostics diagnostics;
  StatisticsState statistics;  // empty without statistics options
};

inline std::int64_t points_of(const Pair& pair, const State& s) {
  std::int64_t points = 0;
  for (std::uint32_t k = 0; k < pair.patch_count; ++k)
    points += s.patches[pair.first_patch + k].point_count;
  return points;
}

}  // namespace firn
