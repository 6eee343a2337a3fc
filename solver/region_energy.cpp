#include "solver/region_energy.h"

#include <cstddef>

namespace firn {

namespace {

struct Corner {
  double x, y, depth;
};

// Integrals over the part of the facets below the plane.
struct Sums {
  double area = 0, depth = 0, square = 0, cube = 0;  // of depth^0 to depth^3
  double area_x = 0, area_y = 0;                     // of x and y
  double square_x = 0, square_y = 0;                 // of depth^2 x and depth^2 y
};

// A triangle without a corner above the plane; its area counts as negative if it turns clockwise.
inline void add_below(Sums& s, const Corner& a, const Corner& b, const Corner& c) {
  const double area = 0.5 * ((b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y));
  const double h1 = a.depth + b.depth + c.depth;
  const double squares = a.depth * a.depth + b.depth * b.depth + c.depth * c.depth;
  const double h2 = 0.5 * (squares + h1 * h1);
  s.area += area;
  s.depth += area * (1.0 / 3) * h1;
  s.square += area * (1.0 / 6) * h2;
  s.cube += area * 0.1 * (h1 * squares + a.depth * b.depth * c.depth);
  s.area_x += area * (1.0 / 3) * (a.x + b.x + c.x);
  s.area_y += area * (1.0 / 3) * (a.y + b.y + c.y);
  const double wa = h2 + a.depth * (h1 + a.depth), wb = h2 + b.depth * (h1 + b.depth),
               wc = h2 + c.depth * (h1 + c.depth);
  s.square_x += area * (1.0 / 30) * (wa * a.x + wb * b.x + wc * c.x);
  s.square_y += area * (1.0 / 30) * (wa * a.y + wb * b.y + wc * c.y);
}

// Where the line from a corner below the plane to one above it meets the plane.
inline Corner crossing(const Corner& below, const Corner& above) {
  const double part = below.depth / (below.depth - above.depth);
  return {below.x + part * (above.x - below.x), below.y + part * (above.y - below.y), 0};
}

void add_triangle(Sums& s, const Corner& a, const Corner& b, const Corner& c) {
  const auto one_below = [&s](const Corner& p, const Corner& q, const Corner& r) {
    add_below(s, p, crossing(p, q), crossing(p, r));
  };
  const auto one_above = [&s](const Corner& p, const Corner& q, const Corner& r) {
    const Corner from_p = crossing(p, r);
    add_below(s, p, q, from_p);
    add_below(s, q, crossing(q, r), from_p);
  };
  switch ((a.depth > 0 ? 1 : 0) + (b.depth > 0 ? 2 : 0) + (c.depth > 0 ? 4 : 0)) {
    case 1:
      return one_below(a, b, c);
    case 2:
      return one_below(b, c, a);
    case 3:
      return one_above(a, b, c);
    case 4:
      return one_below(c, a, b);
    case 5:
      return one_above(c, a, b);
    case 6:
      return one_above(b, c, a);
    case 7:
      return add_below(s, a, b, c);
    default:
      return;
  }
}

// dW = K / (2 I_1) d(I_3) - W / I_1 d(I_1)
RegionEnergy energy_of(double stiffness, const Sums& s) {
  RegionEnergy out;
  if (!(s.depth > 0)) return out;
  const double ratio = s.cube / s.depth;
  const double factor = 0.5 * stiffness / s.depth;
  out.energy = 0.5 * stiffness * ratio;
  out.force = factor * (3 * s.square - ratio * s.area);
  out.moment_x = factor * (3 * s.square_x - ratio * s.area_x);
  out.moment_y = factor * (3 * s.square_y - ratio * s.area_y);
  out.area = s.area;
  out.area_x = s.area_x;
  out.area_y = s.area_y;
  out.volume = s.depth;
  return out;
}

}  // namespace

RegionEnergy region_energy(double stiffness, std::span<const RegionFacet> facets,
                           std::span<const RegionEdge> edges, const RegionMotion& motion) {
  Sums sums;
  const RegionEdge* edge = edges.data();
  for (const RegionFacet& facet : facets) {
    const double depth = facet.depth + motion.depth;
    const double slope_x = facet.slope_x + motion.slope_x;
    const double slope_y = facet.slope_y + motion.slope_y;
    const auto corner = [&](double x, double y) {
      return Corner{x, y, depth + slope_x * x + slope_y * y};
    };
    if (facet.edge_count == 0) continue;
    // Signed triangles from a corner of the outline to each edge.
    const Corner apex = corner(edge->x0, edge->y0);
    for (int k = 0; k < facet.edge_count; ++k, ++edge)
      add_triangle(sums, apex, corner(edge->x0, edge->y0), corner(edge->x1, edge->y1));
  }
  return energy_of(stiffness, sums);
}

FlatRegion flat_region(std::span<const RegionEdge> edges) {
  FlatRegion out;
  if (edges.empty()) return out;
  double sum_x = 0, sum_y = 0;
  const double x = edges[0].x0, y = edges[0].y0;
  for (const RegionEdge& e : edges) {
    const double area = 0.5 * ((e.x0 - x) * (e.y1 - y) - (e.x1 - x) * (e.y0 - y));
    out.area += area;
    sum_x += area / 3 * (e.x0 + e.x1 - 2 * x);
    sum_y += area / 3 * (e.y0 + e.y1 - 2 * y);
  }
  if (!(out.area > 0)) return {};
  out.center_x = x + sum_x / out.area;
  out.center_y = y + sum_y / out.area;
  // Triangles with corners at the centroid, p and q. With su = pu + qu and cuv = pu pv + qu qv, the
  // mean of u v is (su sv + cuv) / 12, and that of u v w is
  // (su sv sw + su cvw + sv cuw + sw cuv + 2 cuvw) / 60.
  for (const RegionEdge& e : edges) {
    const double px = e.x0 - out.center_x, py = e.y0 - out.center_y;
    const double qx = e.x1 - out.center_x, qy = e.y1 - out.center_y;
    const double part = 0.5 * (px * qy - qx * py) / out.area;
    const double sx = px + qx, sy = py + qy;
    const double cxx = px * px + qx * qx, cxy = px * py + qx * qy, cyy = py * py + qy * qy;
    out.xx += part / 12 * (sx * sx + cxx);
    out.xy += part / 12 * (sx * sy + cxy);
    out.yy += part / 12 * (sy * sy + cyy);
    const double cxxx = px * px * px + qx * qx * qx, cxxy = px * px * py + qx * qx * qy;
    const double cxyy = px * py * py + qx * qy * qy, cyyy = py * py * py + qy * qy * qy;
    out.xxx += part / 60 * (sx * sx * sx + 3 * sx * cxx + 2 * cxxx);
    out.xxy += part / 60 * (sx * sx * sy + 2 * sx * cxy + sy * cxx + 2 * cxxy);
    out.xyy += part / 60 * (sx * sy * sy + 2 * sy * cxy + sx * cyy + 2 * cxyy);
    out.yyy += part / 60 * (sy * sy * sy + 3 * sy * cyy + 2 * cyyy);
  }
  return out;
}

RegionEnergy flat_region_energy(double stiffness, const FlatRegion& region,
                                const RegionFacet& facet) {
  const double gx = facet.slope_x, gy = facet.slope_y;
  const double mean = facet.depth + gx * region.center_x + gy * region.center_y;
  // Means over the area of (g . d)^2, (g . d)^3, d (g . d), d (g . d)^2; d from the centroid.
  const double lx = gx * region.xx + gy * region.xy, ly = gx * region.xy + gy * region.yy;
  const double qx = gx * gx * region.xxx + 2 * gx * gy * region.xxy + gy * gy * region.xyy;
  const double qy = gx * gx * region.xxy + 2 * gx * gy * region.xyy + gy * gy * region.yyy;
  const double variance = gx * lx + gy * ly, skew = gx * qx + gy * qy;
  Sums s;
  s.area = region.area;
  s.depth = region.area * mean;
  s.square = region.area * (mean * mean + variance);
  s.cube = region.area * (mean * (mean * mean + 3 * variance) + skew);
  s.area_x = region.area * region.center_x;
  s.area_y = region.area * region.center_y;
  s.square_x = s.square * region.center_x + region.area * (2 * mean * lx + qx);
  s.square_y = s.square * region.center_y + region.area * (2 * mean * ly + qy);
  return energy_of(stiffness, s);
}

bool is_below(std::span<const RegionEdge> edges, const RegionFacet& facet) {
  bool below = true;
  for (const RegionEdge& e : edges)
    below &= facet.depth + facet.slope_x * e.x0 + facet.slope_y * e.y0 >= 0;
  return below;
}

}  // namespace firn
