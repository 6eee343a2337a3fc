// Corners of a part within the contact margin of a surface, in addition to its supporting feature.
#pragma once

#include <algorithm>
#include <span>

#include "solver/collision/contact_region.h"
#include "solver/collision/gjk.h"

namespace firn {

// Bit f is set if the vertex lies on internal face f of its part and `outward` (unit, part axes)
// points out through that face. The contact of such a vertex belongs to the adjacent part, which
// extends farther along `outward`.
inline std::uint64_t leaning_internal_faces(const ConvexPart& part, const Vec3& outward,
                                            int vertex) {
  std::uint64_t mask = part.internal_normals.empty() ? 0 : part.internal_faces[vertex];
  for (std::size_t f = 0; f < part.internal_normals.size(); ++f) {
    if (outward.dot(part.internal_normals[f]) <= kInternalFaceTilt)
      mask &= ~(std::uint64_t{1} << f);
  }
  return mask;
}

// The vertices of a face.
inline std::span<const std::uint16_t> loop_of(const ConvexPart& part,
                                              const ConvexPart::Face& face) {
  return {&part.face_vertices[face.first], static_cast<std::size_t>(face.count)};
}

// A plane surface that faces a part, and the radius (m) of its rounding.
struct CornerSurface {
  HeightGradient plane;
  double radius;
};

// Adds vertices of a part to the region, so that a part that is deep and tilted in a surface has
// contact points wherever it penetrates. A vertex is added if it is within the contact margin of
// the surface, is not in `own`, has no leaning internal face, and is_over(position, height) is
// true. `is_a`: the part is A.
template <class IsOver>
void add_corners(const ProjectedPart& view, bool is_a, std::span<const std::uint16_t> own,
                 const CornerSurface& surface, double contact_margin, const IsOver& is_over,
                 ContactRegion& r) {
  const ConvexPart& part = view.part;
  const double radii = part.radius + surface.radius;
  const Vec3 outward = is_a ? view.n : Vec3(-view.n);
  // The gap is an affine function of the vertex, here with other rounding errors than below. These
  // are far smaller than the contact margin, so that a vertex beyond twice the margin is skipped.
  const HeightGradient& plane = surface.plane;
  const double sign = is_a ? 1 : -1;
  const Vec3 gradient = sign * (plane.du * view.u + plane.dv * view.v - view.n);
  const double at_origin = sign * (plane.at_origin + plane.du * view.shift.x() +
                                   plane.dv * view.shift.y() - view.shift.z()) -
                           radii;
  const double far = 2 * contact_margin + 1e-9 * r.size;
  for (int i = 0; i < part.vertex_count; ++i) {
    if (gradient.x() * part.x[i] + gradient.y() * part.y[i] + gradient.z() * part.z[i] + at_origin >
        far)
      continue;
    const PlanePoint at = view.flat(i);
    const double corner = view.height(i), other = surface.plane.height(at);
    const double gap = (is_a ? other - corner : corner - other) - radii;
    if (!(gap < contact_margin) || std::ranges::find(own, i) != own.end() ||
        leaning_internal_faces(part, outward, i) != 0 || !is_over(at, corner))
      continue;
    r.add(at, is_a ? corner : other, is_a ? other : corner);
    const double width = swept_width(part.radius, -gap, r.size);
    r.points[r.count - 1].weight = width * width;
    r.area += width * width;
  }
}

}  // namespace firn
