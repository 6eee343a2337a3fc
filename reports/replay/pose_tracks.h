// Poses of bodies over time, packed for a page.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "firn/math.h"

namespace firn {

struct PoseTracks {
  std::size_t bodies = 0;
  std::vector<double> time;  // s [T]
  // [T * bodies], frame by frame.
  std::vector<std::array<float, 3>> position;     // m, world; NaN: not there
  std::vector<std::array<float, 4>> orientation;  // unit quaternion w x y z

  // Every n-th of them by time: at most `rate` a second and always the last.
  PoseTracks downsampled(double rate) const;
};

// 16 bits a number. A position is (low + (n + 32767) / 65534 (high - low)), so that it is off by at
// most half a step; n = -32768 in x: the body is not there. A quaternion is n / 32767, sign chosen
// next to that of the frame before, to be normalized: off by less than 1e-4 rad.
//
// `bytes` are, for every channel (x y z, w x y z), body and frame, innermost last, the difference
// from the frame before modulo 2^16 (the first one: from 0), folded so that small ones have small
// numbers (0, -1, 1, -2, ... become 0, 1, 2, 3, ...): first the low bytes of all of them, then the
// high ones.
struct PackedTrajectories {
  std::size_t bodies = 0, frames = 0;
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();  // m
  std::vector<std::uint8_t> bytes;               // [2 * 7 * bodies * frames]
};
PackedTrajectories pack(const PoseTracks& tracks);

}  // namespace firn
