#include "solver/contact/coplanar_contacts.h"

#include <algorithm>
#include <cmath>

#include "solver/collision/contact_region.h"

namespace firn {
namespace {

bool is_same_plane(const ConvexPart::Face* a, const ConvexPart::Face* b, double tolerance) {
  constexpr double kParallel = 1 - 1e-12;  // cosine
  if (a == b) return true;
  return a && b && a->normal.dot(b->normal) > kParallel &&
         std::abs(a->offset - b->offset) <= tolerance;
}

// Moves the mean of the points to `centroid` by weights that change linearly with the position.
// Below this fraction of the extent, hull and faces have the same centroid but for rounding.
void move_centroid(ContactRegion& r, const PlanePoint& centroid, double extent) {
  constexpr double kSameCentroid = 1e-9, kLeastWeight = 0.05;
  double sum = 0, u = 0, v = 0;
  for (int i = 0; i < r.count; ++i) {
    sum += r.points[i].weight;
    u += r.points[i].weight * r.points[i].at.u;
    v += r.points[i].weight * r.points[i].at.v;
  }
  u /= sum;
  v /= sum;
  if (std::hypot(centroid.u - u, centroid.v - v) <= kSameCentroid * extent) return;
  double uu = 0, uv = 0, vv = 0;
  for (int i = 0; i < r.count; ++i) {
    const double du = r.points[i].at.u - u, dv = r.points[i].at.v - v, w = r.points[i].weight / sum;
    uu += w * du * du;
    uv += w * du * dv;
    vv += w * dv * dv;
  }
  const double determinant = uu * vv - uv * uv;
  if (!(determinant > 0)) return;
  const double du = centroid.u - u, dv = centroid.v - v;
  double slope_u = (vv * du - uv * dv) / determinant, slope_v = (uu * dv - uv * du) / determinant;
  double least = 1;
  for (int i = 0; i < r.count; ++i) {
    least =
        std::min(least, 1 + slope_u * (r.points[i].at.u - u) + slope_v * (r.points[i].at.v - v));
  }
  if (least < kLeastWeight) {  // no weight is negative
    slope_u *= (1 - kLeastWeight) / (1 - least);
    slope_v *= (1 - kLeastWeight) / (1 - least);
  }
  for (int i = 0; i < r.count; ++i) {
    r.points[i].weight *= 1 + slope_u * (r.points[i].at.u - u) + slope_v * (r.points[i].at.v - v);
  }
}

}  // namespace

bool is_coplanar(const Manifold& c, const Manifold& d, double tolerance) {
  return !c.outline.empty() && !d.outline.empty() &&
         is_same_plane(c.feature_a.face, d.feature_a.face, tolerance) &&
         is_same_plane(c.feature_b.face, d.feature_b.face, tolerance);
}

void merge_coplanar_contacts(std::span<const PartContact> all, std::span<const int> contacts,
                             std::vector<ManifoldPoint>& out) {
  out.clear();
  const ContactBasis frame(all[contacts[0]].manifold.normal);
  std::vector<PlanePoint> places;
  std::vector<const ManifoldPoint*> points;
  for (const int i : contacts) {
    for (const ManifoldPoint& p : all[i].manifold.outline) {
      places.push_back(frame.flat(p.position));
      points.push_back(&p);
    }
  }
  double extent = 0;
  const std::vector<int> hull = hull_corners(places, extent);
  if (hull.size() < 3) return;
  ContactRegion region(static_cast<int>(hull.size()), extent);
  for (const int c : hull) region.add(places[c], 0, 0);
  compute_polygon_weights(region);
  if (!(region.area > std::pow(kEdgeWidth * extent, 2))) return;
  double area = 0;
  PlanePoint centroid{0, 0};
  for (const int i : contacts) {
    const Manifold& m = all[i].manifold;
    const PlanePoint at = frame.flat(m.centroid);
    area += m.area;
    centroid.u += m.area * at.u;
    centroid.v += m.area * at.v;
  }
  move_centroid(region, {centroid.u / area, centroid.v / area}, extent);
  for (std::size_t i = 0; i < hull.size(); ++i)
    out.push_back({points[hull[i]]->position, points[hull[i]]->gap, region.points[i].weight});
}

}  // namespace firn
