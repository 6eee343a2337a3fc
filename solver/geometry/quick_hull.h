// The convex hull of many points as triangles, fast and approximate: for searches that try many
// hulls. convex_hull() in convex_part.h gives the hull that contacts use.
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

// Points may lie outside of a plane by `tolerance` (m). Nothing for fewer than four points or for
// points that lie in a plane to that tolerance.
std::optional<QuickHull> quick_hull(const std::vector<Vec3>& points, double tolerance);

}  // namespace firn
