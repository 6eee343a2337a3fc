// How pairs of bodies lie to each other, several side by side.
#pragma once

#include "solver/core/simd_batch.h"
#include "solver/state/state.h"

namespace firn {

// Bit for bit what relative_pose() gives for each.
class PairPoses {
 public:
  static constexpr int capacity = Lanes::size;

  // Of the pairs numbers[0] to numbers[count - 1] of a state, 1 to `capacity` of them.
  void find(const State& s, const std::uint32_t* numbers, int count);

  void get_pose(int k, Pose& out) const;  // of b's axes in a's
  // How far b has moved in a's axes since the pair's reference pose (PairMotionBound): its origin,
  // m, and a bound on the way of its points by turning, per m that they are away from it.
  double shift(int k) const { return shift_[k]; }
  double turn(int k) const { return turn_[k]; }

 private:
  Lanes rotation_[9], translation_[3];  // column by column
  Lanes shift_, turn_;
};

}  // namespace firn
