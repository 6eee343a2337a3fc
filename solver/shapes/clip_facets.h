// Division of the boundary of a piece by a plane.
#pragma once

#include <vector>

#include "firn/convex_part.h"
#include "solver/shapes/facets.h"

namespace firn {

struct ClippedFacets {
  std::vector<Facet> below, above;  // boundaries of the two sides; either may be empty
};

// Divides the closed boundary of a piece at the plane of `cut`. Corners within `snap` (m) of the
// plane count as on it. A facet in the plane belongs to the side that it bounds.
// Each side gets a cap that closes it: a cone over the outline of the side in the plane. The apex
// is the projection of `origin` (m) onto the plane. Triangles of a cap may overlap with opposite
// orientations, but volume and signed area add up exactly.
ClippedFacets clip_facets(const std::vector<Facet>& boundary, const HalfSpace& cut, double snap,
                          const Vec3& origin);

}  // namespace firn
