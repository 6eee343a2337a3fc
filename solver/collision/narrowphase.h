// Narrow phase: pure functions from two convex parts and a relative pose to distances and
// manifolds. They are independent of bodies, time and forces.
#pragma once

#include <cstdint>
#include <vector>

#include "firn/convex_part.h"
#include "solver/collision/broadphase.h"

namespace firn {

// Warm start of GJK for one pair of parts: the simplex of the last query, as vertex indices.
struct GjkCache {
  std::uint16_t a[4] = {0, 0, 0, 0};
  std::uint16_t b[4] = {0, 0, 0, 0};
  std::uint16_t count = 0;  // 0: cold
};

struct ManifoldPoint {
  Vec3 position = Vec3::Zero();  // m, A's axes; midway between the two swept surfaces
  double gap = 0;                // m, along the manifold's normal; negative: overlap
  double weight = 0;  // m^2, share of the contact area: linear functions integrate exactly
};

// The flattest supporting feature of a part towards the other one.
struct ContactFeature {
  enum class Kind { vertex, edge, face };
  Kind kind = Kind::vertex;
  const ConvexPart::Face* face = nullptr;
  std::uint16_t ends[2] = {0, 0};  // of an edge; a vertex: the first
};

// All near points of one pair of parts share one normal.
struct Manifold {
  double gap = 0;               // m, smallest distance of the swept surfaces; negative: overlap.
                                // When no points are returned: a lower bound of it.
  Vec3 normal = Vec3::UnitZ();  // unit, from A to B, A's axes
  // Points with a gap below the contact margin. Empty when the parts are farther apart, or when the
  // contact is on an internal face and belongs to the adjacent part.
  std::vector<ManifoldPoint> points;
  // Area moments of the touching region, for torsion (weights as above):
  double area = 0;               // m^2, sum of the weights of the region
  Vec3 centroid = Vec3::Zero();  // m, A's axes
  Mat3 moments = Mat3::Zero();   // m^4, integral of x x^T about the centroid, A's axes
  // Of two faces, or of a face and a plane: all corners of the region, including those beyond the
  // contact margin. Otherwise empty.
  std::vector<ManifoldPoint> outline;
  ContactFeature feature_a, feature_b;  // a plane shows a vertex
};

// A plane surface of a body that is the faces of several parts, as it is not convex.
struct FlatSurface {
  struct Piece {
    std::vector<Vec3> corners;  // m, of the core's face, counter-clockwise, body axes
    Vec3 center = Vec3::Zero();
    double radius = 0;  // m, of a circle around the corners
  };
  std::vector<Piece> pieces;
  AabbTree boxes;  // of the pieces, each slightly larger
};

// The flat surfaces of the parts of one body.
struct FlatSurfaces {
  std::vector<FlatSurface> surfaces;
  // [parts][faces] index into `surfaces`; -1: no other part has a face in that surface. Empty if
  // there are no surfaces.
  std::vector<std::vector<std::int32_t>> of_face;

  bool empty() const { return surfaces.empty(); }
  // Index of the surface with the face or edge `feature` of part `number`; -1: none.
  int find(const ConvexPart& part, int number, const ContactFeature& feature) const;
};

// Finds the faces in one plane that adjoin each other at internal faces.
FlatSurfaces find_flat_surfaces(const std::vector<ConvexPart>& parts);

// Gap, normal and clipped contact points of A against B, `b_in_a` placing B in A's axes.
// Points with a gap above `contact_margin` (m, >= 0) are left out. `out.points` keeps its capacity.
// If the parts are farther apart than `contact_margin`, `gap` may be a lower bound, at least 0.8 of
// the true gap. A contact on an internal face belongs to the adjacent part: no points, but
// `gap` is set.
// Overlaps deeper than both sweep radii go to libccd for the direction; the depth along it is
// exact.
void collide(const ConvexPart& a, const ConvexPart& b, const Pose& b_in_a, double contact_margin,
             GjkCache& cache, Manifold& out);

// collide() for parts with a known side of contact: only separating directions within 45 degrees of
// `side` (unit, A's axes, from A to B) are used, even when another one is shorter.
void collide_with_side_hint(const ConvexPart& a, const ConvexPart& b, const Pose& b_in_a,
                            const Vec3& side, double contact_margin, Manifold& out);

// True when the vertex of `part` farthest along `direction` (part axes) lies on an internal face
// and `direction` points out of the part through that face. The contact then belongs to the
// adjacent part.
bool normal_exits_internal_face(const ConvexPart& part, const Vec3& direction);

// A against the solid half-space { x : n . x <= offset } in A's axes. The manifold's normal is -n
// (from the part to the plane); never fails, however deep. In addition to the lowest feature,
// every vertex within the contact margin is a point, with the weight of a corner.
void collide_plane(const ConvexPart& a, const Vec3& n, double offset, double contact_margin,
                   Manifold& out);

// Replaces the region of two parts by that of the whole surfaces on which they meet: their contact
// does not depend on how a plane surface is cut. Null: a feature without one. `b` null: the plane
// `offset` of collide_plane(). The manifold must come from the same parts and pose. Without effect
// where the parts touch at a border of a surface, beyond the region of the surfaces: this region
// would be less deep than the contact. Returns the smallest gap of the region, m; infinite: no
// effect.
double extend_to_surfaces(const ConvexPart& a, const ConvexPart* b, const Pose& b_in_a,
                          double offset, double contact_margin, const FlatSurface* surface_a,
                          const FlatSurface* surface_b, Manifold& manifold);

// Distance of the two cores (no sweep), m; 0 when they overlap. For reference computations and
// placement.
double core_distance(const ConvexPart& a, const ConvexPart& b, const Pose& b_in_a, GjkCache& cache);

}  // namespace firn
