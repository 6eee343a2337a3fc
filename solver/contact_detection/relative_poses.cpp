#include "solver/contact_detection/relative_poses.h"

#include <algorithm>
#include <cstddef>

namespace firn {

namespace {

// What PairMotionBound begins with, by rows of four.
struct References {
  Columns4 rotation_0_to_3, rotation_4_to_7, rotation_8_translation;
};
static_assert(offsetof(PairMotionBound, reference_rotation) == 0 &&
              offsetof(PairMotionBound, reference_translation) == 9 * sizeof(double));

[[gnu::always_inline]] inline void gather_references(const State& s, const std::size_t* pairs,
                                                     References& out) {
  const auto rows = [&](std::ptrdiff_t first, Columns4 & columns) __attribute__((always_inline)) {
    gather(
        pairs,
        [&](std::size_t p, Simd4d& row) {
          get(reinterpret_cast<const double*>(&s.motion_bound[p]) + first, row);
        },
        columns);
  };
  rows(0, out.rotation_0_to_3);
  rows(4, out.rotation_4_to_7);
  rows(8, out.rotation_8_translation);
}

}  // namespace

void PairPoses::find(const State& s, const std::uint32_t* numbers, int count) {
  std::size_t pairs[capacity], a[capacity], b[capacity];
  for (int k = 0; k < capacity; ++k) {  // lanes beyond `count` repeat the last pair
    pairs[k] = numbers[std::min(k, count - 1)];
    a[k] = static_cast<std::size_t>(s.pairs[pairs[k]].a);
    b[k] = static_cast<std::size_t>(s.pairs[pairs[k]].b);
  }
  const auto orientation = [&](std::size_t i, Simd4d& row) {
    get(s.orientation[i].coeffs().data(), row);
  };
  const auto position = [&](std::size_t i, Simd4d& row) { get(&s.motion[i].position, row); };
  Columns4 q, from, to;
  gather(a, orientation, q);
  const Rotations rotation_a(q);
  gather(b, orientation, q);
  const Rotations rotation_b(q);
  gather(a, position, from);
  gather(b, position, to);
  const Columns3 apart{to.x - from.x, to.y - from.y, to.z - from.z};
  Columns3 in_a;
  for (int column = 0; column < 3; ++column) {
    const Columns3 axis{rotation_b.at[0][column], rotation_b.at[1][column],
                        rotation_b.at[2][column]};
    rotation_a.rotate_inverse(1.0, axis, in_a);
    rotation_[3 * column] = in_a.x;
    rotation_[3 * column + 1] = in_a.y;
    rotation_[3 * column + 2] = in_a.z;
  }
  rotation_a.rotate_inverse(1.0, apart, in_a);
  translation_[0] = in_a.x;
  translation_[1] = in_a.y;
  translation_[2] = in_a.z;

  References then;
  gather_references(s, pairs, then);
  const Simd8d* const reference[9] = {
      &then.rotation_0_to_3.x, &then.rotation_0_to_3.y, &then.rotation_0_to_3.z,
      &then.rotation_0_to_3.w, &then.rotation_4_to_7.x, &then.rotation_4_to_7.y,
      &then.rotation_4_to_7.z, &then.rotation_4_to_7.w, &then.rotation_8_translation.x};
  Simd8d turned(0.0);
  for (int k = 0; k < 9; ++k) {
    const Simd8d d = rotation_[k] - *reference[k];
    turned = turned + d * d;
  }
  // The operator norm of a difference of two rotations is its Frobenius norm over sqrt(2).
  turn_ = square_root(0.5 * turned);
  shift_ = norm(translation_[0] - then.rotation_8_translation.y,
                translation_[1] - then.rotation_8_translation.z,
                translation_[2] - then.rotation_8_translation.w);
}

void PairPoses::get_pose(int k, Pose& out) const {
  for (int i = 0; i < 9; ++i) out.rotation.data()[i] = rotation_[i][k];
  for (int i = 0; i < 3; ++i) out.translation[i] = translation_[i][k];
}

}  // namespace firn
