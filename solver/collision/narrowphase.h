// Narrow phase: pure functions from two convex parts and a relative pose to distances and
// manifolds. They know nothing of bodies, time or forces.
#pragma once

#include <cstdint>
#include <vector>

#include "firn/convex_part.h"

namespace firn {

// Warm start of one pair of parts: the simplex of the last query, as vertex indices.
struct GjkCache {
  std::uint16_t a[4] = {0, 0, 0, 0};
  std::uint16_t b[4] = {0, 0, 0, 0};
  std::uint16_t count = 0;  // 0: cold
};

struct ManifoldPoint {
  Vec3 position;      // m, A's axes; midway between the two swept surfaces
  double gap = 0;     // m, along the manifold's normal; negative: overlap
  double weight = 0;  // m^2, share of the contact area: linear functions integrate exactly
};

// All near points of one pair of parts share one normal.
struct Manifold {
  double gap = 0;               // m, smallest distance of the swept surfaces; negative: overlap.
                                // When no points are returned: a lower bound of it.
  Vec3 normal = Vec3::UnitZ();  // unit, from A to B, A's axes
  std::vector<ManifoldPoint> points;  // those with gap < shell; empty when apart or not ours (seam)
  // Area moments of the touching region, for torsion (weights as above):
  double area = 0;               // m^2, sum of the weights of the region
  Vec3 centroid = Vec3::Zero();  // m, A's axes
  double polar = 0;              // m^4, second polar moment about the centroid
  // Of two faces, or of a face and a plane (face_b null): all corners of the region, also those
  // beyond the shell. Otherwise empty.
  std::vector<ManifoldPoint> outline;
  const ConvexPart::Face* face_a = nullptr;
  const ConvexPart::Face* face_b = nullptr;
};

// Gap, normal and clipped contact points of A against B, `b_in_a` placing B in A's axes.
// Points farther apart than `shell` (m, >= 0) are left out. `out.points` keeps its capacity.
// Apart by more than `shell`: `gap` may be a lower bound, not less than 0.8 of the true one.
// Dropped at a seam (the neighbouring piece has the contact): no points, `gap` as found.
// Overlaps deeper than both sweep radii go to libccd for the direction; the depth along it is
// exact.
void collide(const ConvexPart& a, const ConvexPart& b, const Pose& b_in_a, double shell,
             GjkCache& cache, Manifold& out);

// The same for parts that are known to have met on one side: only ways out within 45 degrees of
// `side` (unit, A's axes, from A to B) count, however much shorter another one is by now.
void collide_from(const ConvexPart& a, const ConvexPart& b, const Pose& b_in_a, const Vec3& side,
                  double shell, Manifold& out);

// True when the vertex of `part` farthest along `way` (part axes) lies on a seam that `way` points
// out through: what happens there is the neighbour's.
bool leads_through_seam(const ConvexPart& part, const Vec3& way);

// A against the solid half-space { x : n . x <= offset } in A's axes. The manifold's normal is -n
// (from the part to the plane); never fails, however deep. In addition to the lowest feature,
// every vertex in the shell is a point, with the weight of a corner.
void collide_plane(const ConvexPart& a, const Vec3& n, double offset, double shell, Manifold& out);

// Distance of the two cores (no sweep), m; 0 when they overlap. For referees and placement.
double core_distance(const ConvexPart& a, const ConvexPart& b, const Pose& b_in_a, GjkCache& cache);

}  // namespace firn
