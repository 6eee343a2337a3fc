#include "solver/collision/contact_region.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace firn {
namespace {

// std::hypot guards against overflow, which lengths in meters cannot reach, at five times the cost.
double length_of(const PlanePoint& a) { return std::sqrt(a.u * a.u + a.v * a.v); }
double dot(const PlanePoint& a, const PlanePoint& b) { return a.u * b.u + a.v * b.v; }
double cross(const PlanePoint& a, const PlanePoint& b) { return a.u * b.v - a.v * b.u; }
PlanePoint operator-(const PlanePoint& a, const PlanePoint& b) { return {a.u - b.u, a.v - b.v}; }

// Projected corners of a face, counter-clockwise seen against the frame's normal.
void outline(const ProjectedPart& view, const ConvexPart::Face& face, bool reversed,
             PlanePoint* out) {
  for (int i = 0; i < face.count; ++i) {
    out[reversed ? face.count - 1 - i : i] = view.flat(view.part.face_vertices[face.first + i]);
  }
}

// An edge as a graph over its partner's and its own mean direction.
struct ClipSegment {
  double along0, along1;    // m, along0 < along1
  double across0, height0;  // at along0
  double turn, rise;        // per length along

  ClipSegment(const ProjectedPart& view, const std::uint16_t (&ends)[2], const PlanePoint& p,
              const PlanePoint& q, const PlanePoint& direction) {
    const bool forward = dot(q - p, direction) > 0;
    const PlanePoint& first = forward ? p : q;
    const PlanePoint& last = forward ? q : p;
    along0 = dot(first, direction);
    along1 = dot(last, direction);
    across0 = cross(direction, first);
    height0 = view.height(ends[forward ? 0 : 1]);
    turn = (cross(direction, last) - across0) / (along1 - along0);
    rise = (view.height(ends[forward ? 1 : 0]) - height0) / (along1 - along0);
  }
  double across(double s) const { return across0 + (s - along0) * turn; }
  double height(double s) const { return height0 + (s - along0) * rise; }
};

}  // namespace

HeightGradient::HeightGradient(const ProjectedPart& view, const ConvexPart::Face& face) {
  const double rise = face.normal.dot(view.n);
  du = -face.normal.dot(view.u) / rise;
  dv = -face.normal.dot(view.v) / rise;
  at_origin = face.offset / rise + view.shift.z() - du * view.shift.x() - dv * view.shift.y();
}

bool is_over_face(const ProjectedPart& view, const ConvexPart::Face& face, bool reversed,
                  const PlanePoint& at) {
  PlanePoint from = view.flat(view.part.face_vertices[face.first + face.count - 1]);
  for (int i = 0; i < face.count; ++i) {
    const PlanePoint to = view.flat(view.part.face_vertices[face.first + i]);
    const double side = cross(to - from, at - from);
    if (reversed ? side > 0 : side < 0) return false;
    from = to;
  }
  return true;
}

int cut(const PlanePoint* in, int count, const PlanePoint& p, const PlanePoint& q,
        PlanePoint* out) {
  const PlanePoint e = q - p;
  int kept = 0;
  PlanePoint from = in[count - 1];
  double from_side = cross(e, from - p);
  for (int i = 0; i < count; ++i) {
    const PlanePoint to = in[i];
    const double to_side = cross(e, to - p);
    if ((from_side < 0) != (to_side < 0)) {
      const double t = from_side / (from_side - to_side);
      out[kept++] = {from.u + t * (to.u - from.u), from.v + t * (to.v - from.v)};
    }
    if (to_side >= 0) out[kept++] = to;
    from = to;
    from_side = to_side;
  }
  return kept;
}

bool clip_segment(const PlanePoint* polygon, int count, const PlanePoint& p, const PlanePoint& q,
                  double& from, double& to) {
  from = 0;
  to = 1;
  for (int i = 0; i < count && from < to; ++i) {
    const PlanePoint e = polygon[i + 1 < count ? i + 1 : 0] - polygon[i];
    const double side_p = cross(e, p - polygon[i]), side_q = cross(e, q - polygon[i]);
    if (side_p < 0 && side_q < 0) return false;
    if (side_p < 0) from = std::max(from, side_p / (side_p - side_q));
    if (side_q < 0) to = std::min(to, side_p / (side_p - side_q));
  }
  return true;
}

std::vector<int> hull_corners(const std::vector<PlanePoint>& points, double& extent) {
  constexpr double kOnLine = 1e-6;  // of the extent: a point on a side is no corner
  std::vector<int> order(points.size()), hull;
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, [&](int i, int k) {
    const PlanePoint &a = points[i], &b = points[k];
    return a.u != b.u ? a.u < b.u : a.v < b.v;
  });
  // Twice the area of a triangle; counter-clockwise counts as positive.
  const auto turn = [&](int a, int b, int c) {
    return cross(points[b] - points[a], points[c] - points[a]);
  };
  // Both chains of the hull, counter-clockwise (Andrew 1979).
  const auto add = [&](int next, std::size_t first) {
    while (hull.size() >= first + 2 && turn(hull[hull.size() - 2], hull.back(), next) <= 0)
      hull.pop_back();
    hull.push_back(next);
  };
  for (const int c : order) add(c, 0);
  hull.pop_back();
  const std::size_t lower = hull.size();
  for (auto c = order.rbegin(); c != order.rend(); ++c) add(*c, lower);
  hull.pop_back();
  extent = 0;
  for (const int c : hull) extent = std::max(extent, length_of(points[c] - points[hull[0]]));
  // A corner on the line of its neighbors is the end of a cut, or a copy of one of them.
  for (std::size_t i = 0; i < hull.size() && hull.size() >= 3;) {
    const int before = hull[(i + hull.size() - 1) % hull.size()];
    const int after = hull[(i + 1) % hull.size()];
    const double chord = length_of(points[after] - points[before]);
    if (turn(before, hull[i], after) > kOnLine * extent * chord) {
      ++i;
    } else {
      hull.erase(hull.begin() + static_cast<std::ptrdiff_t>(i));
      i = i > 0 ? i - 1 : 0;
    }
  }
  return hull;
}

// A fan from the mean of the corners, each triangle giving a third of its area to each corner.
void compute_polygon_weights(ContactRegion& r) {
  PlanePoint mean{0, 0};
  for (int i = 0; i < r.count; ++i) {
    mean.u += r.points[i].at.u / r.count;
    mean.v += r.points[i].at.v / r.count;
  }
  PlaneMoments about;  // about the mean
  PlanePoint p = r.points[r.count - 1].at - mean;
  ClippedPoint* from = &r.points[r.count - 1];
  for (int i = 0; i < r.count; ++i) {
    const PlanePoint q = r.points[i].at - mean;
    const double triangle = 0.5 * cross(p, q);
    from->weight += triangle / 3;
    r.points[i].weight += triangle / 3;
    r.area += triangle;
    about.uu += triangle / 6 * (p.u * p.u + q.u * q.u + p.u * q.u);
    about.uv += triangle / 12 * (2 * (p.u * p.v + q.u * q.v) + p.u * q.v + q.u * p.v);
    about.vv += triangle / 6 * (p.v * p.v + q.v * q.v + p.v * q.v);
    p = q;
    from = &r.points[i];
  }
  PlanePoint centroid{0, 0};  // from the mean
  for (int i = 0; i < r.count; ++i) {
    r.points[i].weight += r.area / (3 * r.count);
    centroid.u += r.points[i].weight * (r.points[i].at.u - mean.u) / r.area;
    centroid.v += r.points[i].weight * (r.points[i].at.v - mean.v) / r.area;
  }
  r.moments.uu = about.uu - r.area * centroid.u * centroid.u;
  r.moments.uv = about.uv - r.area * centroid.u * centroid.v;
  r.moments.vv = about.vv - r.area * centroid.v * centroid.v;
}

double swept_width(double radius, double overlap, double size) {
  return std::max(kEdgeWidth * size, 2 * std::sqrt(2 * radius * std::max(0.0, overlap)));
}

double edge_radius(double radius_a, double radius_b) {
  const double sum = radius_a + radius_b;
  return sum > 0 ? radius_a * radius_b / sum : 0;
}

void compute_segment_weights(ContactRegion& r, double radius, double radii) {
  const auto overlap = [&](const ClippedPoint& p) { return radii - (p.height_b - p.height_a); };
  const double width =
      swept_width(radius, std::max(overlap(r.points[0]), overlap(r.points[1])), r.size);
  const PlanePoint e = r.points[1].at - r.points[0].at;
  const double length = length_of(e);
  r.area = width * length;
  r.points[0].weight = r.points[1].weight = 0.5 * r.area;
  const double density = r.area / 12;
  r.moments = {density * e.u * e.u, density * e.u * e.v, density * e.v * e.v};
}

void compute_point_weights(ContactRegion& r, double radius, double radii) {
  const double width =
      swept_width(radius, radii - (r.points[0].height_b - r.points[0].height_a), r.size);
  r.area = r.points[0].weight = width * width;
  r.moments = {};
}

bool clip_face_face(const ProjectedPart& a, const ConvexPart::Face& face_a, const ProjectedPart& b,
                    const ConvexPart::Face& face_b, ContactRegion& r) {
  const int capacity = region_capacity(face_a.count, face_b.count);
  Scratch<PlanePoint> first(capacity), second(capacity), other(face_b.count);
  PlanePoint* polygon = first.data();
  PlanePoint* spare = second.data();
  PlanePoint* knife = other.data();
  outline(a, face_a, false, polygon);
  outline(b, face_b, true, knife);
  int count = face_a.count;
  for (int i = 0; i < face_b.count && count >= 3; ++i) {
    count = cut(polygon, count, knife[i], knife[i + 1 < face_b.count ? i + 1 : 0], spare);
    std::swap(polygon, spare);
  }
  if (count < 3) return false;
  const HeightGradient over_a(a, face_a), over_b(b, face_b);
  for (int i = 0; i < count; ++i) {
    r.add(polygon[i], over_a.height(polygon[i]), over_b.height(polygon[i]));
  }
  compute_polygon_weights(r);
  return r.area > std::pow(kEdgeWidth * r.size, 2);
}

bool clip_edge_face(const ProjectedPart& edge_view, const std::uint16_t (&ends)[2],
                    const ProjectedPart& face_view, const ConvexPart::Face& face, bool edge_is_a,
                    ContactRegion& r) {
  Scratch<PlanePoint> storage(face.count);
  PlanePoint* polygon = storage.data();
  outline(face_view, face, edge_is_a, polygon);
  const PlanePoint p = edge_view.flat(ends[0]), q = edge_view.flat(ends[1]);
  const double height_p = edge_view.height(ends[0]), height_q = edge_view.height(ends[1]);
  double from, to;  // along p -> q
  if (!clip_segment(polygon, face.count, p, q, from, to)) return false;
  const PlanePoint e = q - p;
  if ((to - from) * length_of(e) < kLeastExtent * r.size) return false;
  const HeightGradient slope(face_view, face);
  for (const double t : {from, to}) {
    const PlanePoint at{p.u + t * e.u, p.v + t * e.v};
    const double on_edge = height_p + t * (height_q - height_p), on_face = slope.height(at);
    r.add(at, edge_is_a ? on_edge : on_face, edge_is_a ? on_face : on_edge);
  }
  compute_segment_weights(r, edge_view.part.radius, edge_view.part.radius + face_view.part.radius);
  return true;
}

bool clip_edge_edge(const ProjectedPart& a, const std::uint16_t (&ends_a)[2],
                    const ProjectedPart& b, const std::uint16_t (&ends_b)[2], double aside,
                    ContactRegion& r) {
  const PlanePoint a0 = a.flat(ends_a[0]), a1 = a.flat(ends_a[1]);
  const PlanePoint b0 = b.flat(ends_b[0]), b1 = b.flat(ends_b[1]);
  const PlanePoint da = a1 - a0, db = b1 - b0;
  const double length_a = length_of(da), length_b = length_of(db);
  if (std::min(length_a, length_b) < kLeastExtent * r.size) return false;
  if (std::abs(cross(da, db)) > 0.5 * length_a * length_b) return false;  // beyond 30 degrees
  const double sign = dot(da, db) > 0 ? 1 / length_b : -1 / length_b;
  PlanePoint middle{da.u / length_a + sign * db.u, da.v / length_a + sign * db.v};
  const double norm = length_of(middle);
  middle = {middle.u / norm, middle.v / norm};
  const ClipSegment on_a(a, ends_a, a0, a1, middle), on_b(b, ends_b, b0, b1, middle);
  double from = std::max(on_a.along0, on_b.along0), to = std::min(on_a.along1, on_b.along1);
  const double opening = on_b.turn - on_a.turn;
  if (opening == 0) {
    if (std::abs(on_b.across(from) - on_a.across(from)) > aside) return false;
  } else {
    const double crossing = from - (on_b.across(from) - on_a.across(from)) / opening;
    from = std::max(from, crossing - aside / std::abs(opening));
    to = std::min(to, crossing + aside / std::abs(opening));
  }
  if (to - from < kLeastExtent * r.size) return false;
  for (const double s : {from, to}) {
    const double across = 0.5 * (on_a.across(s) + on_b.across(s));
    r.add({s * middle.u - across * middle.v, s * middle.v + across * middle.u}, on_a.height(s),
          on_b.height(s));
  }
  compute_segment_weights(r, edge_radius(a.part.radius, b.part.radius),
                          a.part.radius + b.part.radius);
  return true;
}

}  // namespace firn
