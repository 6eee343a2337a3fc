// Force law of several patches in a batch. Quantities of one kind are stored in one array, so that
// the compiler vectorizes the loops and the latency of one patch overlaps with the others.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "solver/contact/contact_law.h"

namespace firn {

// A pair with patches: the input of the force law.
struct ActivePair {
  std::uint32_t pair = 0;  // its number
  std::uint32_t first_patch = 0, patch_count = 0, first_point = 0;
  std::int32_t a = 0, b = 0;  // bodies
  std::int32_t law = 0;       // index into Workspace::laws
  std::uint16_t local_a = 0,
                local_b = 0;  // indices of a and b among the bodies of the range of pairs
};

// Load of one patch on its two bodies in this step. The fourth components of the moments are zero.
struct PatchLoad {
  std::int32_t a, b;   // bodies
  std::int32_t law;    // index into Workspace::laws
  Vec4 force;          // N, on a (opposite on b); fourth: the normal force
  Vec4 moment_a;       // N m, on a, about its center
  Vec4 moment_b;       // N m, on b, about its center (origin)
  double normal;       // N
  double work_normal;  // J taken from the bodies by normal forces
  double work_friction;
};

// Relative motion of two bodies. The fourth components are unused.
struct PairMotion {
  Vec4 velocity;          // m/s, a's minus b's, of the points of both at the center of a
  Vec4 angular_velocity;  // rad/s, a's minus b's
  Vec4 apart;             // m, center of a minus center of b
};

class PatchBlock {
 public:
  // Small enough that patches and points fit into the first-level cache, and that their prefetches
  // do not exceed the outstanding loads of the processor.
  static constexpr int capacity = 8;

  // The arrays that patches come from: `rolling` has a moment for each of `patches`. Bodies from
  // `first_boundary` on are boundaries.
  PatchBlock(ContactPatch* patches, PatchDetail* details, std::int32_t first_boundary)
      : patches_(patches), details_(details), first_boundary_(first_boundary) {}

  // Adds a patch of a pair. Pair, law, patch and points must stay valid until the results of the
  // block have been read. Call while !full().
  void add(const ActivePair& pair, const PairCoefficients& law, ContactPatch& patch,
           ContactPoint* points, const PairMotion& motion) {
    const int k = count_++;
    pair_[k] = &pair;
    law_[k] = &law;
    patch_[k] = &patch;
    points_[k] = points;
    copy_four(&motion.velocity, &motion_[k].velocity);
    copy_four(&motion.angular_velocity, &motion_[k].angular_velocity);
    copy_four(&motion.apart, &motion_[k].apart);
    with_rolling_or_adhesion_ |= !law.has_only_base_law;
    at_boundary_[boundary_count_] = k;
    boundary_count_ += pair.b >= first_boundary_;
  }
  bool full() const { return count_ == capacity; }
  int size() const { return count_; }
  void clear() {
    count_ = boundary_count_ = 0;
    with_rolling_or_adhesion_ = false;
  }
  std::span<const int> at_boundary() const {  // the patches at boundaries
    return {at_boundary_, static_cast<std::size_t>(boundary_count_)};
  }

  // Advances all patches by dt and stores their contact history.
  void advance(double dt);

  // Results of patch k after that.
  std::uint16_t local_a(int k) const { return pair_[k]->local_a; }
  std::uint16_t local_b(int k) const { return pair_[k]->local_b; }
  const Vec4& force(int k) const { return force_[k]; }
  const Vec4& moment_a(int k) const { return moment_a_[k]; }
  const Vec4& moment_b(int k) const { return moment_b_[k]; }
  double normal_force(int k) const { return normal_load_.w[k]; }
  double deepest() const { return deepest_; }  // m, largest overlap of all patches
  double overlap(int k) const {                // m, deepest point
    double deepest = 0;
    for (int i = 0; i < patch_[k]->point_count; ++i)
      deepest = std::max(deepest, -points_[k][i].gap);
    return deepest;
  }
  double work_normal(int k) const { return work_normal_[k]; }
  double work_friction(int k) const { return work_friction_[k]; }
  PatchLoad load(int k) const {
    return {pair_[k]->a,  pair_[k]->b,       pair_[k]->law,   force_[k],        moment_a_[k],
            moment_b_[k], normal_load_.w[k], work_normal_[k], work_friction_[k]};
  }

 private:
  // The components of one Vec4 for each of the patches.
  struct alignas(32) Columns {
    double x[capacity], y[capacity], z[capacity], w[capacity];
    Vec vec(int k) const { return {x[k], y[k], z[k]}; }
    void set(int k, const Vec& v, double fourth) {
      x[k] = v.x;
      y[k] = v.y;
      z[k] = v.z;
      w[k] = fourth;
    }
    // Gathers from or scatters to four rows at any addresses.
    template <class RowOf>
    void gather(int k, const RowOf& row_of);
    template <class RowOf>
    void scatter(int k, const RowOf& row_of) const;
  };
  void pad();
  void gather(int k);  // patches k to k + 3
  void compute_relative_motion(double dt);
  void compute_normal_forces();
  void compute_first_points(int k, Simd4d& deepest);
  [[gnu::always_inline]] inline void compute_further_point(int k, ContactPoint& p);  // of patch k
  [[gnu::always_inline]] inline FrictionRegion region(int k) const;
  void compute_friction(double dt);
  void compute_friction_scale(int first);  // of four patches
  [[gnu::always_inline]] inline void finish_friction(int k, double dt);
  void scatter(int k);
  [[gnu::noinline]] void add_rolling_and_adhesion(double dt);
  void add_rolling_and_adhesion(int k, double dt);

  ContactPatch* patches_;
  PatchDetail* details_;
  std::int32_t first_boundary_;
  int count_ = 0, boundary_count_ = 0;
  double deepest_ = 0;
  const ActivePair* pair_[capacity];
  const PairCoefficients* law_[capacity];
  ContactPatch* patch_[capacity];
  ContactPoint* points_[capacity];
  int at_boundary_[capacity + 1];
  bool with_rolling_or_adhesion_ = false;  // a patch has rolling resistance or adhesion
  ContactPatch padding_patch_;             // completes a group of four,
  ContactPoint padding_point_;             // and its point
  // Rows for exchange with the bodies, columns for the force law.
  PairMotion motion_[capacity];
  Vec4 force_[capacity], moment_a_[capacity], moment_b_[capacity];
  Columns normal_;      // and torsion
  Columns arm_;         // and torsion radius
  Columns tangential_;  // and normal force, afterwards
  Columns spring_;      // stiffness, unloading ratio, minimum unloading ratio
  Columns friction_;    // stiffness, static and dynamic coefficient, restick velocity
  Columns velocity_, angular_velocity_, center_offset_, force_on_a_, moment_, moment_on_b_;
  Columns tilt_;         // and closing
  Columns slip_;         // and turn
  Columns normal_load_;  // sum of force times offset, and normal force
  Columns trial_;        // friction force, and torsion
  Columns scale_;        // factors of FrictionScale
  alignas(32) double needed2_[capacity], limit2_[capacity], trial_sliding_[capacity];
  alignas(32) double elongation_cosine_[capacity], elongation_sine_[capacity];
  alignas(32) double torsion_[capacity], sliding_[capacity], work_normal_[capacity],
      work_friction_[capacity];
  // 1: gaps are advanced, 0: gaps are those of this instant.
  alignas(32) double advance_gap_[capacity];
};

static_assert(offsetof(ContactPatch, torsion) == offsetof(ContactPatch, normal) + sizeof(Vec3) &&
              offsetof(ContactPatch, torsion_radius) ==
                  offsetof(ContactPatch, arm) + sizeof(Vec3) &&
              offsetof(ContactPatch, normal_force) ==
                  offsetof(ContactPatch, tangential) + sizeof(Vec3));
static_assert(offsetof(PairCoefficients, minimum_unloading_ratio) ==
                  offsetof(PairCoefficients, stiffness) + 2 * sizeof(double) &&
              offsetof(PairCoefficients, restick_velocity) ==
                  offsetof(PairCoefficients, tangential_stiffness) + 3 * sizeof(double));
static_assert(offsetof(ContactPoint, gap) == offsetof(ContactPoint, offset) + sizeof(Vec3) &&
              offsetof(ContactPoint, force) == offsetof(ContactPoint, gap) + sizeof(double) &&
              offsetof(ContactPoint, stiffness_fraction) ==
                  offsetof(ContactPoint, force) + sizeof(double));

}  // namespace firn
