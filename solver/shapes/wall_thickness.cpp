#include "solver/shapes/wall_thickness.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "solver/shapes/facets.h"

namespace firn {

double wall_thickness(const TriangleMesh& mesh) {
  const auto facets = sorted_facets(mesh);
  const auto [lower, upper] = bounding_box(mesh);
  const double tiny = 1e-9 * (upper - lower).norm();
  const std::size_t stride = 1 + facets.size() / 300;
  std::vector<std::pair<double, double>> walls;  // thickness, area
  double total = 0;
  for (std::size_t i = 0; i < facets.size(); i += stride) {
    const Vec3 from = facet_centroid(facets[i]), inward = -facets[i].normal;
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& f : facets) {
      const double cosine = f.normal.dot(inward);
      if (cosine <= 0.1) continue;
      const double distance = f.normal.dot(f.corners[0] - from) / cosine;
      if (distance <= tiny || distance >= nearest) continue;
      const Vec3 p = from + distance * inward;
      bool inside = true;
      for (int k = 0; k < 3 && inside; ++k) {
        const Vec3 &a = f.corners[k], &b = f.corners[(k + 1) % 3];
        inside = (b - a).cross(p - a).dot(f.normal) >= -tiny * (b - a).norm();
      }
      if (inside) nearest = distance;
    }
    if (!std::isfinite(nearest)) continue;
    walls.emplace_back(nearest, facet_area(facets[i]));
    total += walls.back().second;
  }
  std::sort(walls.begin(), walls.end());
  double sum = 0;
  for (const auto& [thickness, a] : walls) {
    sum += a;
    if (sum >= 0.05 * total) return thickness;
  }
  return (upper - lower).minCoeff();
}

}  // namespace firn
