// Distance of two convex cores: Gilbert-Johnson-Keerthi, warm started from vertex indices.
// Internal to the narrow phase; users call solver/collision/narrowphase.h.
#pragma once

#include <algorithm>
#include <cstdint>

#include "solver/collision/narrowphase.h"
#include "solver/core/simd.h"

namespace firn {

// Characteristic length of a pair of parts. Tolerances scale with it and do not depend on the unit
// of length: m, the smaller bounding radius; of a bare point and a part, the part's; of two bare
// points, which have none, 1.
inline double characteristic_length(const ConvexPart& a, const ConvexPart& b) {
  const double smaller = std::min(a.bounding_radius, b.bounding_radius);
  const double larger = std::max(a.bounding_radius, b.bounding_radius);
  return smaller > 0 ? smaller : larger > 0 ? larger : 1;
}

// Cores nearer than this part of the pair's size count as overlapping: their distance is too small
// to carry a direction.
inline constexpr double kContactTolerance = 1e-8;
inline double contact_tolerance(const ConvexPart& a, const ConvexPart& b) {
  return kContactTolerance * characteristic_length(a, b);
}

// A contact on an internal face belongs to the adjacent part when the sine of the angle by which
// its normal points out through that face exceeds this.
inline constexpr double kInternalFaceTilt = 1e-9;

// Where two cores meet. Lengths in m, vectors in A's axes.
struct CoreContact {
  double distance = 0;          // of the cores; negative: minus the penetration depth
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

// The vertex farthest along (dx, dy, dz) in part axes. Four vertices at a time (one AVX2 register;
// with wider vectors the compiler passes halves through memory). The padding of the arrays repeats
// the last vertex.
// On a tie the choice is fixed, so results are reproducible.
inline Support support(const ConvexPart& part, double dx, double dy, double dz) {
  using Index = std::int64_t __attribute__((vector_size(32)));
  const double* const x = part.x.data();
  const double* const y = part.y.data();
  const double* const z = part.z.data();
  const auto heights = [&](int i, Simd4d& out) {
    Simd4d vx, vy, vz;
    get(x + i, vx);
    get(y + i, vy);
    get(z + i, vz);
    out = vx * dx + vy * dy + vz * dz;
  };
  // Two independent chains, as the arrays are padded to a multiple of eight.
  const Index lane = {0, 1, 2, 3};
  Simd4d best, second, value, second_value;
  heights(0, best);
  heights(4, second);
  Index at = lane, second_at = lane + 4;
  for (int i = 8; i < part.vertex_count; i += 8) {
    heights(i, value);
    heights(i + 4, second_value);
    const Index farther = value > best, second_farther = second_value > second;
    best = farther ? value : best;
    at = farther ? lane + i : at;
    second = second_farther ? second_value : second;
    second_at = second_farther ? lane + (i + 4) : second_at;
  }
  const Index farther = second > best;
  best = farther ? second : best;
  at = farther ? second_at : at;
  // The better of each half, then of both, without a branch.
  const auto keep_farther = [&](const Simd4d& other, const Index& other_at) {
    const Index is_farther = other > best;
    best = is_farther ? other : best;
    at = is_farther ? other_at : at;
  };
  keep_farther(__builtin_shufflevector(best, best, 1, 0, 3, 2),
               __builtin_shufflevector(at, at, 1, 0, 3, 2));
  keep_farther(__builtin_shufflevector(best, best, 2, 3, 0, 1),
               __builtin_shufflevector(at, at, 2, 3, 0, 1));
  return {std::min(static_cast<int>(at[0]), part.vertex_count - 1), best[0]};
}
inline Support support(const ConvexPart& part, const Vec3& d) {
  return support(part, d.x(), d.y(), d.z());
}

// Distance of the cores of A and B. Stops early, with converged = false, once the swept solids are
// known to be farther apart than `contact_margin` and the lower bound is at least 0.8 of their gap.
// `distance` is 0 and the rest unset when the cores overlap or are nearer than the touching
// distance.
CoreContact core_contact(const ConvexPart& a, const ConvexPart& b, const Pose& b_in_a,
                         double contact_margin, GjkCache& cache);

// Overlapping cores: the minimum translation vector that leads through no internal face, and the
// contact point. distance <= 0 up to rounding and the touching distance.
CoreContact penetration(const ConvexPart& a, const ConvexPart& b, const Pose& b_in_a);

// penetration() restricted to directions within 45 degrees of `side` (unit, A's axes, from A to B),
// for overlapping and separate cores.
CoreContact penetration_from(const ConvexPart& a, const ConvexPart& b, const Pose& b_in_a,
                             const Vec3& side);

}  // namespace firn
