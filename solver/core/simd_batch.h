// Vectors, quaternions and rotations of Simd8d::size bodies side by side, by component.
#pragma once

#include "solver/core/simd.h"

namespace firn {

struct Columns3 {
  Simd8d x, y, z;
};
struct Columns4 {
  Simd8d x, y, z, w;
};

// row_of(number, row) gets the row of each of Simd8d::size numbers.
template <class RowOf>
[[gnu::always_inline]] inline void gather(const std::size_t* numbers, const RowOf& row_of,
                                          Columns4& out) {
  row_of(numbers[0], out.x.low);
  row_of(numbers[1], out.y.low);
  row_of(numbers[2], out.z.low);
  row_of(numbers[3], out.w.low);
  row_of(numbers[4], out.x.high);
  row_of(numbers[5], out.y.high);
  row_of(numbers[6], out.z.high);
  row_of(numbers[7], out.w.high);
  transpose(out.x.low, out.y.low, out.z.low, out.w.low);
  transpose(out.x.high, out.y.high, out.z.high, out.w.high);
}
[[gnu::always_inline]] inline void scatter(Columns4& c, Simd4d* rows) {
  transpose(c.x.low, c.y.low, c.z.low, c.w.low);
  transpose(c.x.high, c.y.high, c.z.high, c.w.high);
  rows[0] = c.x.low;
  rows[1] = c.y.low;
  rows[2] = c.z.low;
  rows[3] = c.w.low;
  rows[4] = c.x.high;
  rows[5] = c.y.high;
  rows[6] = c.z.high;
  rows[7] = c.w.high;
}
[[gnu::always_inline]] inline void get_three(const Vec3& from, Simd4d& v) {
  v = Simd4d{from.x(), from.y(), from.z(), 0};
}
[[gnu::always_inline]] inline void put_three(const Simd4d& v, Vec3& to) {
  to = Vec3(v[0], v[1], v[2]);
}

[[gnu::always_inline]] inline Simd8d norm(const Simd8d& x, const Simd8d& y, const Simd8d& z) {
  return square_root(x * x + (y * y + z * z));
}

// Rotation matrices, row by row, as Eigen makes them of quaternions.
struct Rotations {
  Simd8d at[3][3];

  [[gnu::always_inline]] explicit Rotations(const Columns4& q) {
    const Simd8d tx = 2.0 * q.x, ty = 2.0 * q.y, tz = 2.0 * q.z;
    const Simd8d twx = tx * q.w, twy = ty * q.w, twz = tz * q.w;
    const Simd8d txx = tx * q.x, txy = ty * q.x, txz = tz * q.x;
    const Simd8d tyy = ty * q.y, tyz = tz * q.y, tzz = tz * q.z;
    at[0][0] = 1.0 - (tyy + tzz);
    at[0][1] = txy - twz;
    at[0][2] = txz + twy;
    at[1][0] = txy + twz;
    at[1][1] = 1.0 - (txx + tzz);
    at[1][2] = tyz - twx;
    at[2][0] = txz - twy;
    at[2][1] = tyz + twx;
    at[2][2] = 1.0 - (txx + tyy);
  }
  [[gnu::always_inline]] void rotate(const Columns3& v, Columns4& out) const {
    out.x = at[0][0] * v.x + (at[0][1] * v.y + at[0][2] * v.z);
    out.y = at[1][0] * v.x + (at[1][1] * v.y + at[1][2] * v.z);
    out.z = at[2][0] * v.x + (at[2][1] * v.y + at[2][2] * v.z);
  }
  // scale R^T v; Eigen scales the matrix.
  template <class Vector>
  [[gnu::always_inline]] void rotate_inverse(double scale, const Vector& v, Columns3& out) const {
    const auto scaled = [&](int row, int column) { return scale * at[row][column]; };
    out.x = scaled(0, 0) * v.x + (scaled(1, 0) * v.y + scaled(2, 0) * v.z);
    out.y = scaled(0, 1) * v.x + (scaled(1, 1) * v.y + scaled(2, 1) * v.z);
    out.z = scaled(0, 2) * v.x + (scaled(1, 2) * v.y + scaled(2, 2) * v.z);
  }
};

}  // namespace firn
