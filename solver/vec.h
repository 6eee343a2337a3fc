// Three plain numbers. Innermost loops that live in registers, or that the compiler turns into
// vector code, use these instead of Eigen's vectors.
#pragma once

#include "solver/types.h"

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

inline Vec plain(const Vec3& a) { return {a.x(), a.y(), a.z()}; }
inline Vec3 eigen(const Vec& a) { return {a.x, a.y, a.z}; }

}  // namespace firn
