// Distance of two convex cores: Gilbert-Johnson-Keerthi, warm started from vertex indices.
// Internal to the narrow phase; users call solver/collide.h.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "solver/collide.h"

namespace firn {

// Cores nearer than this (m) count as overlapping: their distance is too small to carry a
// direction.
inline constexpr double kTouchingDistance = 1e-10;

// A normal that leans out over a seam by more than this (sine) belongs to the neighbour there.
inline constexpr double kSeamTilt = 1e-9;

// Where two cores meet. Lengths in m, vectors in A's axes.
struct CoreContact {
  double distance = 0;          // of the cores; negative: depth, the least way out along -normal
  double lower = 0;             // certified lower bound of `distance`, when apart
  bool converged = true;        // false: `lower` alone was enough for the caller
  Vec3 normal = Vec3::UnitZ();  // unit, from A to B
  Vec3 point_a = Vec3::Zero();  // A's nearest point; B's is point_a + distance * normal
  GjkCache simplex;             // vertices that carry the nearest points; at most 3
};

struct Support {
  int vertex;
  double height;  // m: d . x of that vertex
};

// The vertex farthest along (dx, dy, dz) in part axes. Eight vertices at a time; the padding of the
// arrays repeats the last vertex. On a tie the choice is fixed, so results are reproducible.
inline Support support(const ConvexPart& part, double dx, double dy, double dz) {
  using Lanes = double __attribute__((vector_size(64)));
  using Index = std::int64_t __attribute__((vector_size(64)));
  const double* const x = part.x.data();
  const double* const y = part.y.data();
  const double* const z = part.z.data();
  Lanes vx, vy, vz;
  std::memcpy(&vx, x, sizeof vx);
  std::memcpy(&vy, y, sizeof vy);
  std::memcpy(&vz, z, sizeof vz);
  Lanes best = vx * dx + vy * dy + vz * dz;
  const Index lane = {0, 1, 2, 3, 4, 5, 6, 7};
  Index at = lane;
  for (int i = 8; i < part.vertex_count; i += 8) {
    std::memcpy(&vx, x + i, sizeof vx);
    std::memcpy(&vy, y + i, sizeof vy);
    std::memcpy(&vz, z + i, sizeof vz);
    const Lanes value = vx * dx + vy * dy + vz * dz;
    const Index farther = value > best;
    best = farther ? value : best;
    at = farther ? lane + i : at;
  }
  // Fold eight lanes to two, the last two by hand.
  Lanes other = __builtin_shufflevector(best, best, 4, 5, 6, 7, 0, 1, 2, 3);
  Index other_at = __builtin_shufflevector(at, at, 4, 5, 6, 7, 0, 1, 2, 3);
  Index farther = other > best;
  best = farther ? other : best;
  at = farther ? other_at : at;
  other = __builtin_shufflevector(best, best, 2, 3, 0, 1, 6, 7, 4, 5);
  other_at = __builtin_shufflevector(at, at, 2, 3, 0, 1, 6, 7, 4, 5);
  farther = other > best;
  best = farther ? other : best;
  at = farther ? other_at : at;
  const bool second = best[1] > best[0];
  const int vertex = static_cast<int>(second ? at[1] : at[0]);
  return {std::min(vertex, part.vertex_count - 1), second ? best[1] : best[0]};
}
inline Support support(const ConvexPart& part, const Vec3& d) {
  return support(part, d.x(), d.y(), d.z());
}

// Distance of the cores of A and B. Stops early, with converged = false, once the swept solids are
// known to be farther apart than `shell` and the bound is good to a fifth of their gap.
// `distance` is 0 and the rest unset when the cores overlap or are nearer than kTouchingDistance.
CoreContact core_contact(const ConvexPart& a, const ConvexPart& b, const Pose& b_in_a, double shell,
                         GjkCache& cache);

// Overlapping cores: the shallowest way out that leads through no internal face, and where they
// meet. distance <= 0 up to rounding and kTouchingDistance.
CoreContact penetration(const ConvexPart& a, const ConvexPart& b, const Pose& b_in_a);

}  // namespace firn
