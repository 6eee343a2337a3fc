// Three plain numbers. Innermost loops that live in registers, or that the compiler turns into
// vector code, use these instead of Eigen's vectors.
#pragma once

#ifdef __AVX__
#include <immintrin.h>
#endif

#include <bit>
#include <cmath>
#include <cstdint>

#include "firn/math.h"

namespace firn {

struct Vec {
  double x, y, z;
};
inline Vec operator-(const Vec& a, const Vec& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec operator+(const Vec& a, const Vec& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec operator*(double s, const Vec& a) { return {s * a.x, s * a.y, s * a.z}; }
inline double dot(const Vec& a, const Vec& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline double square(const Vec& a) { return dot(a, a); }
inline Vec cross(const Vec& a, const Vec& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// Two unit vectors across a unit vector n, with u x v = n (Duff and others, Journal of Computer
// Graphics Techniques 6 (2017)).
struct TangentBasis {
  Vec u, v;
};
[[gnu::always_inline]] inline TangentBasis tangent_basis(const Vec& n) {
  const double sign = std::copysign(1.0, n.z), a = -1 / (sign + n.z), b = n.x * n.y * a;
  return {{1 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}};
}

// yes ? a : b without a branch, for unpredictable conditions.
inline double select(bool yes, double a, double b) {
  const std::uint64_t mask = -static_cast<std::uint64_t>(yes);
  return std::bit_cast<double>((std::bit_cast<std::uint64_t>(a) & mask) |
                               (std::bit_cast<std::uint64_t>(b) & ~mask));
}
inline int select(bool yes, int a, int b) {
  const int mask = -static_cast<int>(yes);
  return (a & mask) | (b & ~mask);
}

// Three numbers and a fourth one, loaded into one wide register.
struct alignas(32) Vec4 {
  double x, y, z, w;
};
// Four doubles in one register, and its type in memory without alignment. The types are GCC's
// vector extensions and not those of a SIMD library, because one source then compiles for SSE2 and
// AVX2: Highway 1.0.3 and xsimd 8.1 have no type of four doubles without AVX. Never passed by
// value, because sources compiled without AVX would warn. Copied by these types and not by
// std::memcpy, which moves halves, so that a later wide load must wait.
using Simd4d = double __attribute__((vector_size(32)));
using UnalignedSimd4d __attribute__((vector_size(32), aligned(8), may_alias)) = double;
[[gnu::always_inline]] inline void get(const void* from, Simd4d& v) {
  v = *static_cast<const UnalignedSimd4d*>(from);
}
[[gnu::always_inline]] inline void put(const Simd4d& v, void* to) {
  *static_cast<UnalignedSimd4d*>(to) = v;
}
[[gnu::always_inline]] inline void copy_four(const void* from, void* to) {
  *static_cast<UnalignedSimd4d*>(to) = *static_cast<const UnalignedSimd4d*>(from);
}
// Four rows of four into four columns of four, or back.
[[gnu::always_inline]] inline void transpose(Simd4d& a, Simd4d& b, Simd4d& c, Simd4d& d) {
  const Simd4d ab_even = __builtin_shufflevector(a, b, 0, 4, 2, 6);
  const Simd4d ab_odd = __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const Simd4d cd_even = __builtin_shufflevector(c, d, 0, 4, 2, 6);
  const Simd4d cd_odd = __builtin_shufflevector(c, d, 1, 5, 3, 7);
  a = __builtin_shufflevector(ab_even, cd_even, 0, 1, 4, 5);
  b = __builtin_shufflevector(ab_odd, cd_odd, 0, 1, 4, 5);
  c = __builtin_shufflevector(ab_even, cd_even, 2, 3, 6, 7);
  d = __builtin_shufflevector(ab_odd, cd_odd, 2, 3, 6, 7);
}
// The square roots, in place.
[[gnu::always_inline]] inline void square_root(Simd4d& v) {
#ifdef __AVX__
  v = _mm256_sqrt_pd(v);
#else
  for (int k = 0; k < 4; ++k) v[k] = std::sqrt(v[k]);
#endif
}

// Which of four comparisons hold, one bit each.
using Mask4d = std::int64_t __attribute__((vector_size(32)));
[[gnu::always_inline]] inline unsigned movemask(const Mask4d& holds) {
#ifdef __AVX__
  return static_cast<unsigned>(_mm256_movemask_pd(reinterpret_cast<const __m256d&>(holds)));
#else
  unsigned bits = 0;
  for (int k = 0; k < 4; ++k) bits |= static_cast<unsigned>(holds[k] & 1) << k;
  return bits;
#endif
}

// Eight numbers side by side, as two registers of four (AVX2): operations on both overlap, which
// hides the latency of a long chain of them. Always inline: sources compiled with and
// without AVX would pass them differently.
struct Simd8d {
  static constexpr int size = 8;
  Simd4d low, high;

  Simd8d() = default;
  explicit Simd8d(double all) : low{all, all, all, all}, high(low) {}
  [[gnu::always_inline]] Simd8d(const Simd4d& l, const Simd4d& h) : low(l), high(h) {}
  double operator[](int i) const { return i < 4 ? low[i] : high[i - 4]; }
  void set(int i, double value) {
    if (i < 4)
      low[i] = value;
    else
      high[i - 4] = value;
  }

  [[gnu::always_inline]] friend Simd8d operator+(const Simd8d& a, const Simd8d& b) {
    return {a.low + b.low, a.high + b.high};
  }
  [[gnu::always_inline]] friend Simd8d operator-(const Simd8d& a, const Simd8d& b) {
    return {a.low - b.low, a.high - b.high};
  }
  [[gnu::always_inline]] friend Simd8d operator*(const Simd8d& a, const Simd8d& b) {
    return {a.low * b.low, a.high * b.high};
  }
  [[gnu::always_inline]] friend Simd8d square_root(const Simd8d& a) {
    Simd8d out = a;
    square_root(out.low);
    square_root(out.high);
    return out;
  }
  [[gnu::always_inline]] friend Simd8d operator*(double a, const Simd8d& b) {
    return {a * b.low, a * b.high};
  }
  [[gnu::always_inline]] friend Simd8d operator-(double a, const Simd8d& b) {
    return {a - b.low, a - b.high};
  }
};

inline Vec to_vec(const Vec4& a) { return {a.x, a.y, a.z}; }

inline Vec to_vec(const Vec3& a) { return {a.x(), a.y(), a.z()}; }
inline Vec3 to_eigen(const Vec& a) { return {a.x, a.y, a.z}; }

}  // namespace firn
