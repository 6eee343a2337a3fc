// Bounding spheres of the convex parts of all present particles, and which of two particles' come
// near each other: what the neighbour list is made from.
#pragma once

#include <span>
#include <vector>

#include "solver/core/simd.h"
#include "solver/state/workspace.h"

namespace firn {

// m: tests that save others let this much more through than those do.
inline constexpr double kRounding = 1e-9;

// Four spheres of a particle side by side. A particle that has not as many fills up its last group
// with spheres infinitely far away, which are near nothing.
struct SphereGroup {
  static constexpr int size = 4;
  Quad x, y, z, radius;  // m, world
};

struct BoundingSpheres {
  std::vector<int> particle;       // [present] ids, along a curve through space
  std::vector<std::size_t> first;  // [present + 1] into groups
  std::vector<SphereGroup> groups;
  std::vector<Quad> places;   // [present] m, world, centre of mass, and the margin
  std::vector<Aabb> boxes;    // [present] m, world, of all spheres with the margin around
  std::vector<double> reach;  // [shapes] m, of all spheres from the centre of mass

  std::span<const SphereGroup> of(std::size_t k) const {
    return {groups.data() + first[k], first[k + 1] - first[k]};
  }
  Vec3 center(std::size_t k, std::size_t part) const {
    const SphereGroup& g = groups[first[k] + part / SphereGroup::size];
    const std::size_t lane = part % SphereGroup::size;
    return {(&g.x.x)[lane], (&g.y.x)[lane], (&g.z.x)[lane]};
  }
};
BoundingSpheres update_bounding_spheres(const Model& model, const Workspace& w, const State& s);

// Lists the parts of a and b, ascending, whose spheres come nearer each other than `margins` (m).
// All spheres of b lie within `reach` (m) around `center`. `found` has room for all pairs of
// parts and for SphereGroup::size more. Returns how many it has found.
int find_close_parts(std::span<const SphereGroup> a, std::span<const SphereGroup> b,
                     const Vec3& center, double reach, double margins, PartNumbers* found);

}  // namespace firn
