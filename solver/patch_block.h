// The force law of many patches side by side: numbers of like kind lie together, so that the
// compiler makes vector code of it, and the long chain of one patch is hidden behind the others.
#pragma once

#include "solver/contact.h"

namespace firn {

// What one patch adds to its two bodies in this step.
struct PatchLoad {
  std::int32_t a, b;   // bodies
  std::int32_t law;    // index into Workspace::laws
  Vec force;           // N, on a; b feels the opposite
  Vec moment_a;        // N m, on a, about its centre
  Vec moment_b;        // N m, on b, about its centre (origin)
  double normal;       // N
  double overlap;      // m, deepest point
  double work_normal;  // J taken from the bodies by normal forces
  double work_friction;
};

// Two bodies against each other.
struct PairMotion {
  Vec velocity;  // m/s, a's minus b's, of the points of both at the centre of a
  Vec spin;      // rad/s, a's minus b's
  Vec apart;     // m, centre of a minus centre of b
};

class PatchBlock {
 public:
  static constexpr int room = 32;

  // Adds a patch of bodies a and b; `law` is number `law_index`. Law, patch and points must stay
  // until the block has advanced. Call while !full().
  void add(std::int32_t a, std::int32_t b, std::int32_t law_index, const PairLaw& law, Patch& patch,
           ContactPoint* points, const PairMotion& motion);
  bool full() const { return count_ == room; }
  int size() const { return count_; }
  void clear() { count_ = 0; }

  // Advances all patches by dt and writes their memory back.
  void advance(double dt);

  // What patch k does after that.
  PatchLoad load(int k) const {
    return {a_[k],
            b_[k],
            law_index_[k],
            {force_x[k], force_y[k], force_z[k]},
            {moment_x[k], moment_y[k], moment_z[k]},
            {counter_x[k], counter_y[k], counter_z[k]},
            normal_force_[k],
            overlap_[k],
            work_normal_[k],
            work_friction_[k]};
  }

 private:
  using Numbers = double[room];
  void approach_all(double dt);
  void press_all();
  void rub_all(double dt);
  void store_all(double dt);

  int count_ = 0;
  std::int32_t a_[room], b_[room], law_index_[room];
  const PairLaw* law_[room];
  Patch* patch_[room];
  ContactPoint* points_[room];
  // Components of the vectors of all patches.
  alignas(32) Numbers normal_x, normal_y, normal_z;
  Numbers arm_x, arm_y, arm_z, apart_x, apart_y, apart_z;
  Numbers velocity_x, velocity_y, velocity_z, spin_x, spin_y, spin_z;
  Numbers tangential_x, tangential_y, tangential_z, torsion_, torsion_radius, sliding_;
  Numbers stiffness_, static_, dynamic_, speed_;
  Numbers closing, tilt_x, tilt_y, tilt_z, slip_x, slip_y, slip_z, turn;
  Numbers normal_force_, offset_x, offset_y, offset_z, overlap_, work_normal_, work_friction_;
  Numbers force_x, force_y, force_z, moment_x, moment_y, moment_z;  // on a
  Numbers counter_x, counter_y, counter_z;                          // moment on b
};

}  // namespace firn
