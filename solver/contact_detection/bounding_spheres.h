// Bounding spheres of the convex parts of all present particles, and the pairs of spheres of two
// particles that are close to each other. The neighbor list is made from them.
#pragma once

#include <span>
#include <vector>

#include "solver/core/simd.h"
#include "solver/state/workspace.h"

namespace firn {

// m: a preliminary test accepts this much more distance than the final one, so that it rejects
// nothing that the final one accepts.
inline constexpr double kRounding = 1e-9;

// Four spheres of a particle in one group. The last group of a particle is padded with spheres at
// infinity, which are close to nothing.
struct SphereGroup {
  static constexpr int size = 4;
  Vec4 x, y, z, radius;  // m, world
};

struct BoundingSpheres {
  std::vector<int> particle;       // [present] ids, along a curve through space
  std::vector<std::size_t> first;  // [present + 1] into groups
  std::vector<SphereGroup> groups;
  std::vector<Vec4> places;   // [present] m, world, center of mass, and the margin
  std::vector<Aabb> boxes;    // [present] m, world, of all spheres with the margin around
  std::vector<double> reach;  // [shapes] m, of all spheres from the center of mass

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

// Lists, in ascending order, the parts of a and b whose spheres are closer to each other than
// `margins` (m). All spheres of b lie within `reach` (m) around `center`. `found` has space for all
// pairs of parts and for SphereGroup::size more. Returns the number of pairs found.
int find_close_parts(std::span<const SphereGroup> a, std::span<const SphereGroup> b,
                     const Vec3& center, double reach, double margins, PartNumbers* found);

}  // namespace firn
