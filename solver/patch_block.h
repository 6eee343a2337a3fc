// The force law of many patches side by side: numbers of like kind lie together, so that the
// compiler makes vector code of it, and the long chain of one patch is hidden behind the others.
#pragma once

#include <cstddef>

#include "solver/contact.h"

namespace firn {

// A pair with patches, as the force law walks through them.
struct ActivePair {
  std::uint32_t pair;  // its number
  std::uint32_t first_patch, patch_count;
  std::int32_t a, b;               // bodies
  std::int32_t law;                // index into Workspace::laws
  std::uint16_t local_a, local_b;  // which of the bodies of a range of pairs these are
};

// What one patch adds to its two bodies in this step. The fourth numbers of the moments are zero.
struct PatchLoad {
  std::int32_t a, b;   // bodies
  std::int32_t law;    // index into Workspace::laws
  Quad force;          // N, on a; b feels the opposite; and the normal force
  Quad moment_a;       // N m, on a, about its centre
  Quad moment_b;       // N m, on b, about its centre (origin)
  double normal;       // N
  double overlap;      // m, deepest point
  double work_normal;  // J taken from the bodies by normal forces
  double work_friction;
};

// Two bodies against each other. The fourth numbers are of no meaning.
struct PairMotion {
  Quad velocity;  // m/s, a's minus b's, of the points of both at the centre of a
  Quad spin;      // rad/s, a's minus b's
  Quad apart;     // m, centre of a minus centre of b
};

class PatchBlock {
 public:
  static constexpr int room = 32;

  // The arrays that patches come from: `rolling` has a moment for each of `patches`.
  PatchBlock(Patch* patches, Vec3* rolling) : patches_(patches), rolling_(rolling) {}

  // Adds a patch of a pair. Pair, law, patch and points must stay until the block has been read.
  // Call while !full().
  void add(const ActivePair& pair, const PairLaw& law, Patch& patch, ContactPoint* points,
           const PairMotion& motion) {
    const int k = count_++;
    pair_[k] = &pair;
    law_[k] = &law;
    patch_[k] = &patch;
    points_[k] = points;
    copy_four(&patch.normal, &normal_rows_[k]);
    copy_four(&patch.arm, &arm_rows_[k]);
    copy_four(&patch.tangential, &tangential_rows_[k]);
    copy_four(&law.tangential_stiffness, &friction_rows_[k]);
    copy_four(&motion.velocity, &velocity_rows_[k]);
    copy_four(&motion.spin, &spin_rows_[k]);
    copy_four(&motion.apart, &apart_rows_[k]);
    sliding_[k] = patch.sliding;
  }
  bool full() const { return count_ == room; }
  int size() const { return count_; }
  void clear() { count_ = 0; }

  // Advances all patches by dt and writes their memory back.
  void advance(double dt);

  // What patch k does after that.
  std::int32_t b(int k) const { return pair_[k]->b; }
  std::uint16_t local_a(int k) const { return pair_[k]->local_a; }
  std::uint16_t local_b(int k) const { return pair_[k]->local_b; }
  const Quad& force(int k) const { return force_[k]; }
  const Quad& moment_a(int k) const { return moment_a_[k]; }
  const Quad& moment_b(int k) const { return moment_b_[k]; }
  double normal_force(int k) const { return pressed_.w[k]; }
  double overlap(int k) const { return overlap_[k]; }
  double work_normal(int k) const { return work_normal_[k]; }
  double work_friction(int k) const { return work_friction_[k]; }
  PatchLoad load(int k) const {
    return {pair_[k]->a,  pair_[k]->b,   pair_[k]->law, force_[k],       moment_a_[k],
            moment_b_[k], pressed_.w[k], overlap_[k],   work_normal_[k], work_friction_[k]};
  }

 private:
  // The components of a Quad for all patches.
  struct alignas(32) Columns {
    double x[room], y[room], z[room], w[room];
    Vec vec(int k) const { return {x[k], y[k], z[k]}; }
    void set(int k, const Vec& v, double fourth) {
      x[k] = v.x;
      y[k] = v.y;
      z[k] = v.z;
      w[k] = fourth;
    }
  };
  void spread(const Quad* rows, Columns& columns) const;
  void collect(const Columns& columns, Quad* rows) const;
  void approach_all(double dt);
  void press_all();
  void rub_all(double dt);
  void store_all(double dt);
  [[gnu::noinline]] void add_options(int k, double dt);  // rolling resistance and adhesion

  Patch* patches_;
  Vec3* rolling_;
  int count_ = 0;
  const ActivePair* pair_[room];
  const PairLaw* law_[room];
  Patch* patch_[room];
  ContactPoint* points_[room];
  // Rows as they come from and go to bodies and patches, and columns as the law wants them.
  Quad normal_rows_[room];      // and torsion
  Quad arm_rows_[room];         // and torsion radius
  Quad tangential_rows_[room];  // and normal force, afterwards
  Quad friction_rows_[room];    // stiffness, static, dynamic, sliding speed
  Quad velocity_rows_[room], spin_rows_[room], apart_rows_[room];
  Quad force_[room], moment_a_[room], moment_b_[room];
  Columns normal_, arm_, tangential_, friction_, velocity_, spin_, apart_, push_, moment_, counter_;
  Columns tilt_;     // and closing
  Columns slip_;     // and turn
  Columns pressed_;  // sum of force times offset, and normal force
  alignas(32) double torsion_[room], sliding_[room], overlap_[room], work_normal_[room],
      work_friction_[room];
};

static_assert(offsetof(Patch, torsion) == offsetof(Patch, normal) + sizeof(Vec3) &&
              offsetof(Patch, torsion_radius) == offsetof(Patch, arm) + sizeof(Vec3) &&
              offsetof(Patch, normal_force) == offsetof(Patch, tangential) + sizeof(Vec3));
static_assert(offsetof(PairLaw, sliding_speed) ==
              offsetof(PairLaw, tangential_stiffness) + 3 * sizeof(double));

}  // namespace firn
