// The region over which two bodies meet on plane surfaces that consist of faces of several parts.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "solver/collision/contact_region.h"
#include "solver/collision/corner_points.h"
#include "solver/collision/gjk.h"
#include "solver/collision/narrowphase.h"
#include "solver/collision/surface_pieces.h"

namespace firn {
namespace {

// Polygons of one body seen along the normal, all counter-clockwise.
using Polygons = std::vector<std::vector<PlanePoint>>;

struct Box {
  double low[2], high[2];

  void extend(const PlanePoint& p) {
    low[0] = std::min(low[0], p.u);
    low[1] = std::min(low[1], p.v);
    high[0] = std::max(high[0], p.u);
    high[1] = std::max(high[1], p.v);
  }
  bool overlaps(const Box& other) const {
    return low[0] <= other.high[0] && other.low[0] <= high[0] && low[1] <= other.high[1] &&
           other.low[1] <= high[1];
  }
};

constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr Box kEmptyBox{{kFar, kFar}, {-kFar, -kFar}};

Box box_of(const std::vector<PlanePoint>& polygon) {
  Box box = kEmptyBox;
  for (const PlanePoint& p : polygon) box.extend(p);
  return box;
}

Box box_of(const Polygons& polygons) {
  Box box = kEmptyBox;
  for (const std::vector<PlanePoint>& polygon : polygons) {
    for (const PlanePoint& p : polygon) box.extend(p);
  }
  return box;
}

// Of a convex polygon, counter-clockwise.
bool contains(const std::vector<PlanePoint>& polygon, const PlanePoint& at) {
  PlanePoint from = polygon.back();
  for (const PlanePoint& to : polygon) {
    if ((to.u - from.u) * (at.v - from.v) - (to.v - from.v) * (at.u - from.u) < 0) return false;
    from = to;
  }
  return true;
}

// The box around the places of a plane face that are seen within `box`, in axes of the part.
Aabb box_on_face(const ProjectedPart& view, const ConvexPart::Face& face, const Box& box) {
  const HeightGradient slope(view, face);
  Aabb out{Vec3::Constant(kFar), Vec3::Constant(-kFar)};
  for (const double u : {box.low[0], box.high[0]}) {
    for (const double v : {box.low[1], box.high[1]}) {
      const Vec3 x = view.body_point({u, v}, slope.height({u, v}));
      out.lower = out.lower.cwiseMin(x);
      out.upper = out.upper.cwiseMax(x);
    }
  }
  return out;
}

// Of a face, or of its surface the pieces that may be seen within a box.
Polygons outlines(const ProjectedPart& view, const ConvexPart::Face& face,
                  const FlatSurface* surface, bool reversed, const Box* within) {
  Polygons out;
  const auto add = [&](const std::vector<Vec3>& corners) {
    std::vector<PlanePoint>& polygon = out.emplace_back();
    for (const Vec3& x : corners) polygon.push_back(view.flat(x));
    if (reversed) std::ranges::reverse(polygon);
  };
  if (!surface) {
    add(piece_of(view.part, face).corners);
  } else if (!within) {
    for (const FlatSurface::Piece& piece : surface->pieces) add(piece.corners);
  } else {
    std::vector<int> near;
    surface->boxes.find(box_on_face(view, face, *within), near);
    for (const int i : near) add(surface->pieces[static_cast<std::size_t>(i)].corners);
  }
  return out;
}

// Corners of the common parts of two sets of convex polygons.
std::vector<PlanePoint> common_corners(const Polygons& first, const Polygons& second) {
  std::vector<PlanePoint> all, clipped, spare;
  for (const std::vector<PlanePoint>& a : first) {
    const Box box = box_of(a);
    for (const std::vector<PlanePoint>& b : second) {
      if (!box.overlaps(box_of(b))) continue;
      const std::size_t room = 2 * (a.size() + b.size());
      clipped.resize(room);
      spare.resize(room);
      std::ranges::copy(a, clipped.begin());
      int count = static_cast<int>(a.size());
      for (std::size_t i = 0; i < b.size() && count >= 3; ++i) {
        count = cut(clipped.data(), count, b[i], b[i + 1 < b.size() ? i + 1 : 0], spare.data());
        std::swap(clipped, spare);
      }
      if (count >= 3) all.insert(all.end(), clipped.begin(), clipped.begin() + count);
    }
  }
  return all;
}

// The edge with all that continues it on the outline of the surface.
LineSegment whole_edge(const ConvexPart& part, const ContactFeature& edge,
                       const FlatSurface* surface) {
  LineSegment whole{part.vertex(edge.ends[0]), part.vertex(edge.ends[1])};
  if (!surface) return whole;
  const double tolerance = kNoGap * part.bounding_radius;
  for (bool grown = true; grown;) {
    grown = false;
    const double length = (whole.to - whole.from).norm();
    const Vec3 along = (whole.to - whole.from) / length;
    for (const FlatSurface::Piece& piece : surface->pieces) {
      if ((piece.center - whole.from).cross(along).norm() > piece.radius + tolerance) continue;
      for (std::size_t i = 0; i < piece.corners.size(); ++i) {
        const LineSegment side = side_of(piece, i);
        double from, to;
        if (!is_on_line(whole, side, tolerance, from, to)) continue;
        const LineSegment ordered = from < to ? side : LineSegment{side.to, side.from};
        if (from > to) std::swap(from, to);
        if (from > length + tolerance || to < -tolerance) continue;
        if (from < -tolerance) whole.from = ordered.from;
        if (to > length + tolerance) whole.to = ordered.to;
        grown = from < -tolerance || to > length + tolerance;
        if (grown) break;
      }
      if (grown) break;
    }
  }
  return whole;
}

// The corners of a region and the heights of both cores there.
struct WholeRegion {
  std::vector<PlanePoint> corners;
  std::vector<std::array<double, 2>> heights;  // m, of a and b
  const ConvexPart* swept = nullptr;           // of an edge or a vertex, its part; null: a polygon
};

// The convex hull of a cut polygon, between two planes.
template <class HeightA, class HeightB>
WholeRegion hull_region(const std::vector<PlanePoint>& points, const HeightA& height_a,
                        const HeightB& height_b) {
  WholeRegion out;
  if (points.size() < 3) return out;
  double extent = 0;
  for (const int i : hull_corners(points, extent)) {
    const PlanePoint& at = points[static_cast<std::size_t>(i)];
    out.corners.push_back(at);
    out.heights.push_back({height_a(at), height_b(at)});
  }
  return out;
}

WholeRegion region_of_faces(const ProjectedPart& a, const ConvexPart::Face& face_a,
                            const FlatSurface* surface_a, const ProjectedPart& b,
                            const ConvexPart::Face& face_b, const FlatSurface* surface_b) {
  const HeightGradient over_a(a, face_a), over_b(b, face_b);
  Polygons on_a, on_b;
  if (surface_a && !surface_b) {
    on_b = outlines(b, face_b, nullptr, true, nullptr);
    const Box around = box_of(on_b);
    on_a = outlines(a, face_a, surface_a, false, &around);
  } else {
    on_a = outlines(a, face_a, surface_a, false, nullptr);
    const Box around = box_of(on_a);
    on_b = outlines(b, face_b, surface_b, true, &around);
  }
  return hull_region(
      common_corners(on_a, on_b), [&](const PlanePoint& p) { return over_a.height(p); },
      [&](const PlanePoint& p) { return over_b.height(p); });
}

// From the first to the last point of the edge that is over the surface.
WholeRegion region_of_edge(const ProjectedPart& edge_view, const LineSegment& edge,
                           const ProjectedPart& face_view, const ConvexPart::Face& face,
                           const FlatSurface* surface, bool edge_is_a, double size) {
  WholeRegion out;
  const PlanePoint p = edge_view.flat(edge.from), q = edge_view.flat(edge.to);
  Box around = kEmptyBox;
  around.extend(p);
  around.extend(q);
  double from = 1, to = 0;  // along the edge
  for (const std::vector<PlanePoint>& polygon :
       outlines(face_view, face, surface, edge_is_a, &around)) {
    double begin, end;
    if (!clip_segment(polygon.data(), static_cast<int>(polygon.size()), p, q, begin, end) ||
        begin >= end)
      continue;
    from = std::min(from, begin);
    to = std::max(to, end);
  }
  if ((to - from) * std::hypot(q.u - p.u, q.v - p.v) < kLeastExtent * size) return out;
  const HeightGradient slope(face_view, face);
  const double height_p = edge_view.height(edge.from), height_q = edge_view.height(edge.to);
  for (const double t : {from, to}) {
    const PlanePoint at{p.u + t * (q.u - p.u), p.v + t * (q.v - p.v)};
    const double on_edge = height_p + t * (height_q - height_p), on_face = slope.height(at);
    out.corners.push_back(at);
    out.heights.push_back({edge_is_a ? on_edge : on_face, edge_is_a ? on_face : on_edge});
  }
  out.swept = &edge_view.part;
  return out;
}

// A face or an edge on the plane at the height `level`.
WholeRegion region_on_plane(const ProjectedPart& a, const ContactFeature& feature,
                            const FlatSurface* surface, double level) {
  if (feature.kind == ContactFeature::Kind::face) {
    std::vector<PlanePoint> all;
    for (const std::vector<PlanePoint>& polygon :
         outlines(a, *feature.face, surface, false, nullptr))
      all.insert(all.end(), polygon.begin(), polygon.end());
    const HeightGradient over_a(a, *feature.face);
    return hull_region(
        all, [&](const PlanePoint& p) { return over_a.height(p); },
        [&](const PlanePoint&) { return level; });
  }
  WholeRegion out;
  const LineSegment edge = whole_edge(a.part, feature, surface);
  for (const Vec3& x : {edge.from, edge.to}) {
    out.corners.push_back(a.flat(x));
    out.heights.push_back({a.height(x), level});
  }
  out.swept = &a.part;
  return out;
}

// True when a vertex with the projected position `at` and this height (m) lies on the feature: in
// the plane of a face, on the line of an edge, or at a vertex.
bool is_on_feature(const ProjectedPart& view, const ContactFeature& feature, const PlanePoint& at,
                   double height) {
  const double tolerance = kNoGap * view.part.bounding_radius;
  if (feature.face)
    return std::abs(height - HeightGradient(view, *feature.face).height(at)) <= tolerance;
  const PlanePoint from = view.flat(feature.ends[0]);
  const double du = at.u - from.u, dv = at.v - from.v;
  if (feature.kind == ContactFeature::Kind::vertex) return std::hypot(du, dv) <= tolerance;
  const PlanePoint to = view.flat(feature.ends[1]);
  const double length = std::hypot(to.u - from.u, to.v - from.v);
  return std::abs((to.u - from.u) * dv - (to.v - from.v) * du) <= tolerance * length;
}

WholeRegion whole_region(const ProjectedPart& a, const ProjectedPart& b, const Manifold& m,
                         const FlatSurface* surface_a, const FlatSurface* surface_b, double size) {
  using Kind = ContactFeature::Kind;
  const ContactFeature &on_a = m.feature_a, &on_b = m.feature_b;
  if (on_a.kind == Kind::face && on_b.kind == Kind::face)
    return region_of_faces(a, *on_a.face, surface_a, b, *on_b.face, surface_b);
  if (on_a.kind == Kind::edge && on_b.kind == Kind::face)
    return region_of_edge(a, whole_edge(a.part, on_a, surface_a), b, *on_b.face, surface_b, true,
                          size);
  if (on_a.kind == Kind::face && on_b.kind == Kind::edge)
    return region_of_edge(b, whole_edge(b.part, on_b, surface_b), a, *on_a.face, surface_a, false,
                          size);
  // A vertex: its contact point is known.
  WholeRegion out;
  if ((on_a.face || on_b.face) && !m.points.empty()) {
    const ManifoldPoint& p = m.points.front();
    const double middle = a.n.dot(p.position);
    out.corners.push_back(a.flat(p.position));
    out.heights.push_back(
        {middle - 0.5 * p.gap - a.part.radius, middle + 0.5 * p.gap + b.part.radius});
    out.swept = on_a.face ? &b.part : &a.part;
  }
  return out;
}

}  // namespace

double extend_to_surfaces(const ConvexPart& a, const ConvexPart* b, const Pose& b_in_a,
                          double offset, double contact_margin, const FlatSurface* surface_a,
                          const FlatSurface* surface_b, Manifold& m) {
  constexpr double kNoEffect = std::numeric_limits<double>::infinity();
  if (!b && m.feature_a.kind == ContactFeature::Kind::vertex) return kNoEffect;
  const ContactBasis frame(m.normal);
  const ProjectedPart view_a(a, frame);
  const double size = b ? characteristic_length(a, *b) : a.bounding_radius,
               radius_b = b ? b->radius : 0;
  const WholeRegion whole =
      b ? whole_region(view_a, ProjectedPart(*b, frame, b_in_a), m, surface_a, surface_b, size)
        : region_on_plane(view_a, m.feature_a, surface_a, -offset);
  if (whole.corners.size() < (whole.swept ? 1u : 3u)) return kNoEffect;
  ContactRegion region(
      static_cast<int>(whole.corners.size()) + a.vertex_count + (b ? b->vertex_count : 0), size);
  for (std::size_t i = 0; i < whole.corners.size(); ++i)
    region.add(whole.corners[i], whole.heights[i][0], whole.heights[i][1]);
  if (whole.corners.size() == 1) {
    compute_point_weights(region, whole.swept->radius, a.radius + radius_b);
  } else if (whole.swept) {
    compute_segment_weights(region, whole.swept->radius, a.radius + radius_b);
  } else {
    compute_polygon_weights(region);
    if (!(region.area > std::pow(kEdgeWidth * size, 2))) return kNoEffect;
  }
  const std::size_t own = static_cast<std::size_t>(region.count);
  if (!b) {
    const auto is_over = [&](const PlanePoint& at, double height) {
      return !is_on_feature(view_a, m.feature_a, at, height);
    };
    add_corners(view_a, true, {}, {HeightGradient(-offset), radius_b}, contact_margin, is_over,
                region);
  } else {
    const ProjectedPart view_b(*b, frame, b_in_a);
    const auto add_over = [&](const ProjectedPart& corners, const ContactFeature& feature,
                              const ProjectedPart& face_view, const ContactFeature& other,
                              const FlatSurface* surface, bool is_a) {
      if (!other.face) return;
      const auto is_over = [&](const PlanePoint& at, double height) {
        if (is_on_feature(corners, feature, at, height)) return false;
        Box around = kEmptyBox;
        around.extend(at);
        return std::ranges::any_of(
            outlines(face_view, *other.face, surface, is_a, &around),
            [&](const std::vector<PlanePoint>& polygon) { return contains(polygon, at); });
      };
      add_corners(corners, is_a, {},
                  {HeightGradient(face_view, *other.face), face_view.part.radius}, contact_margin,
                  is_over, region);
    };
    add_over(view_a, m.feature_a, view_b, m.feature_b, surface_b, true);
    add_over(view_b, m.feature_b, view_a, m.feature_a, surface_a, false);
  }
  double least = kNoEffect;
  for (int i = 0; i < region.count; ++i)
    least = std::min(least, region.points[i].height_b - region.points[i].height_a);
  least -= a.radius + radius_b;
  if (!(least < contact_margin) || least > m.gap + kLeastExtent * size) return kNoEffect;
  m.points.clear();
  m.outline.clear();
  m.centroid.setZero();
  const bool flat = !whole.swept && static_cast<std::size_t>(region.count) == own;
  emit_region(region, frame, a.radius, radius_b, contact_margin, flat, m);
  return least;
}

}  // namespace firn
