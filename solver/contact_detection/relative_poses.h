// Relative poses of several pairs of bodies, computed in vectors.
#pragma once

#include "solver/core/simd_batch.h"
#include "solver/state/state.h"

namespace firn {

// Bit-identical to relative_pose() for each pair.
class PairPoses {
 public:
  static constexpr int capacity = Simd8d::size;

  // Computes the poses of the pairs numbers[0] to numbers[count - 1] of a state; `count` is 1 to
  // `capacity`.
  void find(const State& s, const std::uint32_t* numbers, int count);

  void get_pose(int k, Pose& out) const;  // of b's axes in a's
  // Displacement of b in a's axes since the reference pose of the pair (PairMotionBound): of its
  // origin, m, and a bound on the displacement of its points by rotation, per m of distance from
  // the origin.
  double shift(int k) const { return shift_[k]; }
  double turn(int k) const { return turn_[k]; }

 private:
  Simd8d rotation_[9], translation_[3];  // column by column
  Simd8d shift_, turn_;
};

}  // namespace firn
