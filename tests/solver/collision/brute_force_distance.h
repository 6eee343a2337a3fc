// Parts for the narrow-phase tests, and a slow referee that shares no idea with the code under
// test: every pair of features for the distance, every separating axis for the depth.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "solver/collision/narrowphase.h"

namespace firn::testing {

inline std::vector<HalfSpace> box_planes(const Vec3& lower, const Vec3& upper) {
  std::vector<HalfSpace> planes;
  for (int axis = 0; axis < 3; ++axis) {
    planes.push_back({Vec3::Unit(axis), upper[axis], false});
    planes.push_back({-Vec3::Unit(axis), -lower[axis], false});
  }
  return planes;
}

// A box with its drawn faces at +- half.
inline ConvexPart box(const Vec3& half, double radius) {
  return convex_part(box_planes(-half, half), radius);
}

// The same box cut along x into `count` equal slabs; the cuts are seams.
inline std::vector<ConvexPart> slabs(const Vec3& half, double radius, int count) {
  std::vector<ConvexPart> parts;
  for (int k = 0; k < count; ++k) {
    Vec3 lower = -half, upper = half;
    lower.x() = -half.x() + 2 * half.x() * k / count;
    upper.x() = -half.x() + 2 * half.x() * (k + 1) / count;
    auto planes = box_planes(lower, upper);
    planes[0].internal = k + 1 < count;
    planes[1].internal = k > 0;
    parts.push_back(convex_part(planes, radius));
  }
  return parts;
}

// Uniform numbers that do not depend on the standard library's distributions.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double uniform(double a, double b) {
    return a + (b - a) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  int below(int n) { return static_cast<int>(engine_() % static_cast<std::uint64_t>(n)); }
  Vec3 direction() {
    for (;;) {
      const Vec3 v(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
      if (v.squaredNorm() < 1 && v.squaredNorm() > 1e-4) return v.normalized();
    }
  }
  Mat3 rotation() {
    return Eigen::AngleAxisd(uniform(0, 2 * M_PI), direction()).toRotationMatrix();
  }

 private:
  std::mt19937_64 engine_;
};

struct InitialParticle {
  std::vector<Vec3> vertices;
  std::vector<Vec3> normals;
  std::vector<std::array<Vec3, 2>> edges;
  std::vector<std::array<Vec3, 3>> triangles;
};

inline InitialParticle place(const ConvexPart& part, const Pose& pose) {
  InitialParticle out;
  for (int i = 0; i < part.vertex_count; ++i) out.vertices.push_back(pose * part.vertex(i));
  for (const auto& e : part.edges) out.edges.push_back({out.vertices[e[0]], out.vertices[e[1]]});
  for (const auto& f : part.faces) {
    out.normals.push_back(pose.rotation * f.normal);
    const auto* loop = &part.face_vertices[f.first];
    for (int k = 1; k + 1 < f.count; ++k) {
      out.triangles.push_back(
          {out.vertices[loop[0]], out.vertices[loop[k]], out.vertices[loop[k + 1]]});
    }
  }
  return out;
}

inline double segment_distance(const Vec3& p, const Vec3& a, const Vec3& b) {
  const double t = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return (p - a - t * (b - a)).norm();
}

// Both distances below are those of two points that lie on the features, so that no cancellation in
// a sliver or between almost parallel edges can make them too small.
inline double triangle_distance(const Vec3& p, const std::array<Vec3, 3>& t) {
  const Vec3 n = (t[1] - t[0]).cross(t[2] - t[0]);
  double out = std::numeric_limits<double>::infinity(), inside[3], sum = 0;
  for (int i = 0; i < 3; ++i) {
    const Vec3& a = t[i];
    const Vec3& b = t[(i + 1) % 3];
    inside[i] = n.cross(b - a).dot(p - a);
    sum += inside[i];
    out = std::min(out, segment_distance(p, a, b));
  }
  if (!(inside[0] >= 0 && inside[1] >= 0 && inside[2] >= 0 && sum > 0)) return out;
  // The weight of a corner comes from the side that faces it.
  const Vec3 foot = (inside[1] * t[0] + inside[2] * t[1] + inside[0] * t[2]) / sum;
  return std::min(out, (p - foot).norm());
}

// Nearest points of two segments that cross; ends are left to vertex against face.
inline double edge_distance(const std::array<Vec3, 2>& e, const std::array<Vec3, 2>& f) {
  const Vec3 u = e[1] - e[0], v = f[1] - f[0], w = f[0] - e[0];
  const Vec3 n = u.cross(v);
  const double n2 = n.squaredNorm();
  if (n2 <= 1e-24 * u.squaredNorm() * v.squaredNorm()) {
    return std::numeric_limits<double>::infinity();
  }
  double s = w.cross(v).dot(n) / n2, t = w.cross(u).dot(n) / n2;
  if (s < 0 || s > 1 || t < 0 || t > 1) return std::numeric_limits<double>::infinity();
  // Once more from either side: where edges are almost parallel, rounding has moved both.
  t = std::clamp((e[0] + s * u - f[0]).dot(v) / v.squaredNorm(), 0.0, 1.0);
  s = std::clamp((f[0] + t * v - e[0]).dot(u) / u.squaredNorm(), 0.0, 1.0);
  return (e[0] + s * u - f[0] - t * v).norm();
}

// How far apart (positive) along n; negative: how far B must move along n.
inline double separation(const InitialParticle& a, const InitialParticle& b, const Vec3& n) {
  double high_a = -std::numeric_limits<double>::infinity(), low_b = -high_a;
  for (const Vec3& v : a.vertices) high_a = std::max(high_a, n.dot(v));
  for (const Vec3& v : b.vertices) low_b = std::min(low_b, n.dot(v));
  return low_b - high_a;
}

// Largest separation over all face normals and edge pairs: below zero exactly when the cores
// overlap, and then minus their depth.
inline double largest_separation(const InitialParticle& a, const InitialParticle& b) {
  double out = -std::numeric_limits<double>::infinity();
  for (const Vec3& n : a.normals) out = std::max(out, separation(a, b, n));
  for (const Vec3& n : b.normals) out = std::max(out, separation(a, b, -n));
  for (const auto& e : a.edges) {
    for (const auto& f : b.edges) {
      const Vec3 u = (e[1] - e[0]).normalized(), v = (f[1] - f[0]).normalized();
      Vec3 n = u.cross(v);
      if (n.norm() < 1e-7) continue;  // a face normal does as well
      n.normalize();
      out = std::max({out, separation(a, b, n), separation(a, b, -n)});
    }
  }
  return out;
}

inline double apart_distance(const InitialParticle& a, const InitialParticle& b) {
  double out = std::numeric_limits<double>::infinity();
  for (const Vec3& p : a.vertices) {
    for (const auto& t : b.triangles) out = std::min(out, triangle_distance(p, t));
  }
  for (const Vec3& p : b.vertices) {
    for (const auto& t : a.triangles) out = std::min(out, triangle_distance(p, t));
  }
  for (const auto& e : a.edges) {
    for (const auto& f : b.edges) out = std::min(out, edge_distance(e, f));
  }
  if (a.vertices.size() == 1 && b.vertices.size() == 1) {
    out = (a.vertices[0] - b.vertices[0]).norm();
  }
  return out;
}

// Distance of the cores, or minus their depth.
inline double referee(const ConvexPart& a, const ConvexPart& b, const Pose& b_in_a) {
  const InitialParticle pa = place(a, Pose{}), pb = place(b, b_in_a);
  const double s = largest_separation(pa, pb);
  return s > 0 || (pa.triangles.empty() && pb.triangles.empty()) ? apart_distance(pa, pb) : s;
}

}  // namespace firn::testing
