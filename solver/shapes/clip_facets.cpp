#include "solver/shapes/clip_facets.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace firn {
namespace {

struct Segment {
  Vec3 a = Vec3::Zero(), b = Vec3::Zero();
};
// Where the boundary of a side meets the plane of the cut. Segments of the cap of an earlier cut
// are collinear, and most of them cancel.
struct Outline {
  std::vector<Segment> surface;
  std::vector<std::pair<Vec3, std::vector<Segment>>> caps;  // by the normal of the cap
};

void add_segment(const Facet& f, const Vec3& a, const Vec3& b, Outline& outline) {
  if (!f.cap) {
    outline.surface.push_back({a, b});
    return;
  }
  for (auto& [normal, segments] : outline.caps) {
    if (normal == f.normal) {
      segments.push_back({a, b});
      return;
    }
  }
  outline.caps.push_back({f.normal, {{a, b}}});
}

// Closes a side by a cone over its outline. Collinear segments are merged first.
void add_cap(const HalfSpace& cut, const Vec3& normal, const Outline& outline, double snap,
             const Vec3& origin, std::vector<Facet>& out) {
  const Vec3 apex = origin - (cut.normal.dot(origin) - cut.offset) * cut.normal;
  for (const auto& s : outline.surface) out.push_back({{apex, s.b, s.a}, normal, true});
  for (const auto& [other, segments] : outline.caps) {
    const Vec3 across = other.cross(normal);
    if (across.norm() < 1e-9) {  // a cap in this very plane
      for (const auto& s : segments) out.push_back({{apex, s.b, s.a}, normal, true});
      continue;
    }
    const Vec3 along = across.normalized(), start = segments[0].a;
    std::vector<std::pair<double, int>> ends;  // position along the line, change of its coverage
    for (const auto& s : segments) {
      ends.emplace_back(along.dot(s.a - start), 1);
      ends.emplace_back(along.dot(s.b - start), -1);
    }
    std::sort(ends.begin(), ends.end());
    int cover = 0;
    double from = 0;
    for (std::size_t i = 0; i < ends.size();) {
      const double at = ends[i].first;
      int change = 0;
      for (; i < ends.size() && ends[i].first - at <= snap; ++i) change += ends[i].second;
      if (change == 0) continue;
      const Vec3 p = start + from * along, q = start + at * along;
      for (int k = 0; k < std::abs(cover); ++k) {
        if (cover > 0) out.push_back({{apex, q, p}, normal, true});
        if (cover < 0) out.push_back({{apex, p, q}, normal, true});
      }
      cover += change;
      from = at;
    }
  }
}

// The part of a facet below the plane (sign 1) or above it (-1), and its edge in the plane.
void keep_side(const Facet& f, const std::array<double, 3>& h, int sign, std::vector<Facet>& out,
               Outline& outline) {
  if (sign * h[0] < 0 && sign * h[1] < 0 && sign * h[2] < 0) {
    out.push_back(f);
    return;
  }
  std::array<Vec3, 4> polygon;
  std::array<bool, 4> on;
  int n = 0;
  for (int k = 0; k < 3; ++k) {
    const int next = (k + 1) % 3;
    if (sign * h[k] <= 0) {
      polygon[n] = f.corners[k];
      on[n++] = h[k] == 0;
    }
    if (h[k] * h[next] < 0) {
      // From the lower end, so that both facets at the edge get the same point.
      const int a = h[k] < h[next] ? k : next, b = h[k] < h[next] ? next : k;
      polygon[n] = f.corners[a] + h[a] / (h[a] - h[b]) * (f.corners[b] - f.corners[a]);
      on[n++] = true;
    }
  }
  for (int k = 1; k + 1 < n; ++k) {
    out.push_back({{polygon[0], polygon[k], polygon[k + 1]}, f.normal, f.cap});
  }
  for (int k = 0; k < n; ++k) {
    const int next = (k + 1) % n;
    if (on[k] && on[next]) add_segment(f, polygon[k], polygon[next], outline);
  }
}

}  // namespace

ClippedFacets clip_facets(const std::vector<Facet>& boundary, const HalfSpace& cut, double snap,
                          const Vec3& origin) {
  ClippedFacets sides;
  Outline low_outline, high_outline;
  sides.below.reserve(boundary.size());
  sides.above.reserve(boundary.size());
  for (const auto& f : boundary) {
    std::array<double, 3> h;
    for (int k = 0; k < 3; ++k) {
      h[k] = cut.normal.dot(f.corners[k]) - cut.offset;
      if (std::abs(h[k]) <= snap) h[k] = 0;
    }
    const auto [low, high] = std::minmax({h[0], h[1], h[2]});
    if (low == 0 && high == 0) {  // a facet in the plane belongs to the body on its inner side
      const bool up = f.normal.dot(cut.normal) > 0;
      (up ? sides.below : sides.above).push_back(f);
      for (int k = 0; k < 3; ++k) {
        add_segment(f, f.corners[k], f.corners[(k + 1) % 3], up ? low_outline : high_outline);
      }
      continue;
    }
    if (low < 0) keep_side(f, h, 1, sides.below, low_outline);
    if (high > 0) keep_side(f, h, -1, sides.above, high_outline);
  }
  add_cap(cut, cut.normal, low_outline, snap, origin, sides.below);
  add_cap(cut, -cut.normal, high_outline, snap, origin, sides.above);
  return sides;
}

}  // namespace firn
