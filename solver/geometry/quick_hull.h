// Fast approximate convex hull as triangles, for searches over many hulls. Contacts use the exact
// convex_hull() of convex_part.h.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "firn/convex_part.h"

namespace firn {

struct QuickHull {
  std::vector<std::array<int, 3>> triangles;  // indices of the points, counter-clockwise
  std::vector<HalfSpace> planes;              // [triangles] n . x <= offset, m
  std::vector<int> corners;                   // indices of the points on the hull, ascending
  double volume = 0;                          // m^3
};

// Points may be outside of a plane by `tolerance` (m). Nothing for fewer than four points and for
// points that are coplanar within the tolerance.
std::optional<QuickHull> quick_hull(const std::vector<Vec3>& points, double tolerance);

}  // namespace firn
