#include "solver/geometry/quick_hull.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace firn {
namespace {

// A triangle of the hull under construction.
struct Facet {
  std::array<int, 3> corners = {};
  std::array<int, 3> neighbors = {-1, -1, -1};  // across corners k, k + 1
  Vec3 normal = Vec3::Zero();
  double offset = 0;
  // Points above this facet that the hull does not contain yet: a list through Builder::next_.
  int first_above = -1, last_above = -1;
  int farthest = -1;
  double distance = 0;
  bool alive = true;
};

// Indices of points, each place once: of points with the same bits, the first.
std::vector<int> distinct_points(const std::vector<Vec3>& points) {
  const std::size_t mask = std::bit_ceil(2 * points.size() + 1) - 1;
  std::vector<int> slots(mask + 1, -1);  // a hash table
  std::vector<int> distinct;
  distinct.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto bits = std::bit_cast<std::array<std::uint64_t, 3>>(
        std::array<double, 3>{points[i].x(), points[i].y(), points[i].z()});
    std::uint64_t hash = 0;
    for (const std::uint64_t word : bits) {
      hash = (hash ^ word) * 0x9e3779b97f4a7c15;
      hash ^= hash >> 32;
    }
    std::size_t slot = hash & mask;
    const auto differs = [&points, i](int other) {
      return std::memcmp(points[other].data(), points[i].data(), 3 * sizeof(double)) != 0;
    };
    while (slots[slot] >= 0 && differs(slots[slot])) slot = (slot + 1) & mask;
    if (slots[slot] >= 0) continue;
    slots[slot] = static_cast<int>(i);
    distinct.push_back(static_cast<int>(i));
  }
  return distinct;
}

class Builder {
 public:
  Builder(const std::vector<Vec3>& points, double tolerance)
      : points_(points),
        tolerance_(tolerance),
        next_(points.size(), -1),
        edge_to_(points.size(), -1) {}

  std::optional<QuickHull> build() {
    if (points_.size() < 4 || !start()) return std::nullopt;
    for (std::size_t f = 0; f < facets_.size(); ++f) {
      // New facets come at the end; one facet is asked again until nothing lies above it.
      while (facets_[f].alive && facets_[f].farthest >= 0) {
        if (!add_point(static_cast<int>(f))) skip_farthest(facets_[f]);
      }
    }
    return finish();
  }

 private:
  double height(const Facet& f, int p) const { return f.normal.dot(points_[p]) - f.offset; }

  bool set_plane(Facet& f) const {
    const Vec3 &a = points_[f.corners[0]], &b = points_[f.corners[1]], &c = points_[f.corners[2]];
    const Vec3 n = (b - a).cross(c - a);
    const double length = n.norm();
    if (!(length > 0)) return false;
    f.normal = n / length;
    f.offset = f.normal.dot(a + b + c) / 3;
    return true;
  }

  void note(Facet& f, int p, double distance) {
    (f.last_above < 0 ? f.first_above : next_[f.last_above]) = p;
    f.last_above = p;
    next_[p] = -1;
    if (distance > f.distance) {
      f.distance = distance;
      f.farthest = p;
    }
  }

  void skip_farthest(Facet& f) {
    const int skipped = f.farthest;
    int p = f.first_above;
    f.first_above = f.last_above = f.farthest = -1;
    f.distance = 0;
    while (p >= 0) {
      const int next = next_[p];
      if (p != skipped) note(f, p, height(f, p));
      p = next;
    }
  }

  // A first tetrahedron of points far from each other.
  bool start() {
    // Meshes hold each corner about six times. Copies cannot be corners of the hull.
    const std::vector<int> distinct = distinct_points(points_);
    std::array<int, 2> line = {0, 0};
    double longest = 0;
    for (int k = 0; k < 3; ++k) {
      const auto [low, high] =
          std::minmax_element(points_.begin(), points_.end(),
                              [k](const Vec3& a, const Vec3& b) { return a(k) < b(k); });
      const double length = (*high - *low).norm();
      if (length > longest) {
        longest = length;
        line = {static_cast<int>(low - points_.begin()), static_cast<int>(high - points_.begin())};
      }
    }
    if (longest <= tolerance_) return false;
    const Vec3 origin = points_[line[0]], along = (points_[line[1]] - origin).normalized();
    int third = -1, fourth = -1;
    double widest = tolerance_;
    for (const int i : distinct) {
      const Vec3 arm = points_[i] - origin;
      const double width = (arm - along.dot(arm) * along).norm();
      if (width > widest) {
        widest = width;
        third = i;
      }
    }
    if (third < 0) return false;
    const Vec3 normal = along.cross(points_[third] - origin).normalized();
    double highest = tolerance_;
    for (const int i : distinct) {
      const double up = std::abs(normal.dot(points_[i] - origin));
      if (up > highest) {
        highest = up;
        fourth = i;
      }
    }
    if (fourth < 0) return false;
    const bool above = normal.dot(points_[fourth] - origin) > 0;
    const int a = line[0], b = above ? third : line[1], c = above ? line[1] : third, d = fourth;
    const std::array<std::array<int, 3>, 4> loops = {{{a, b, c}, {a, d, b}, {b, d, c}, {c, d, a}}};
    const std::array<std::array<int, 3>, 4> across = {{{1, 2, 3}, {3, 2, 0}, {1, 3, 0}, {2, 1, 0}}};
    for (int k = 0; k < 4; ++k) {
      Facet f;
      f.corners = loops[k];
      f.neighbors = across[k];
      if (!set_plane(f)) return false;
      facets_.push_back(f);
    }
    facets_.reserve(4 * distinct.size());
    for (const int i : distinct) assign_points(i, 0);
    return true;
  }

  // Gives a point to the facet, from the number `first` on, that it lies highest above.
  void assign_points(int p, std::size_t first) {
    Facet* best = nullptr;
    double most = tolerance_;
    for (std::size_t f = first; f < facets_.size(); ++f) {
      const double d = height(facets_[f], p);
      if (d > most) {
        most = d;
        best = &facets_[f];
      }
    }
    if (best) note(*best, p, most);
  }

  // Extends the hull to the farthest point of a facet. False when rounding forbids it.
  bool add_point(int first) {
    const int eye = facets_[first].farthest;
    find_visible(first, eye);
    find_horizon();
    const bool closes = make_fresh(eye);
    for (const auto& edge : horizon_) edge_to_[edge[0]] = -1;
    for (const int v : visible_) state_[v] = 0;
    if (!closes || fresh_.size() < 3) return false;
    const std::size_t base = facets_.size();
    append_fresh();
    for (const int v : visible_) {
      facets_[v].alive = false;
      for (int p = facets_[v].first_above; p >= 0;) {
        const int next = next_[p];
        if (p != eye) assign_points(p, base);
        p = next;
      }
    }
    return true;
  }

  // Lists and marks the facets that are seen from a point, starting at one of them.
  void find_visible(int first, int eye) {
    visible_ = {first};
    state_.resize(facets_.size(), 0);
    state_[first] = 1;
    for (std::size_t i = 0; i < visible_.size(); ++i) {
      const Facet& f = facets_[visible_[i]];
      for (int k = 0; k < 3; ++k) {
        const int next = f.neighbors[k];
        if (state_[next]) continue;
        if (height(facets_[next], eye) > tolerance_) {
          state_[next] = 1;
          visible_.push_back(next);
        }
      }
    }
  }

  // Lists the edges between visible and other facets.
  void find_horizon() {
    horizon_.clear();
    for (const int v : visible_) {
      const Facet& f = facets_[v];
      for (int k = 0; k < 3; ++k) {
        if (!state_[f.neighbors[k]]) {
          horizon_.push_back({f.corners[k], f.corners[(k + 1) % 3], f.neighbors[k]});
        }
      }
    }
  }

  // Makes the facets from the horizon to the point, numbered from the end of facets_. False when
  // the horizon is no simple loop, or a facet has no plane. Writes edge_to_ along the horizon.
  bool make_fresh(int eye) {
    bool simple = true;
    fresh_.clear();
    const int base = static_cast<int>(facets_.size());
    for (const auto& [a, b, outer] : horizon_) {
      Facet f;
      f.corners = {a, b, eye};
      f.neighbors = {outer, -1, -1};
      simple = simple && edge_to_[a] < 0 && set_plane(f);
      edge_to_[a] = base + static_cast<int>(fresh_.size());
      fresh_.push_back(f);
    }
    for (std::size_t i = 0; simple && i < fresh_.size(); ++i) {
      const int next = edge_to_[fresh_[i].corners[1]];
      simple = next >= 0;
      if (!simple) break;
      fresh_[i].neighbors[1] = next;
      fresh_[next - base].neighbors[2] = base + static_cast<int>(i);
    }
    return simple;
  }

  // Adds the new facets to the hull, next to the facets beyond the horizon.
  void append_fresh() {
    for (const auto& f : fresh_) {
      const int index = static_cast<int>(facets_.size());
      Facet& outer = facets_[f.neighbors[0]];
      for (int k = 0; k < 3; ++k) {
        if (outer.corners[k] == f.corners[1] && outer.corners[(k + 1) % 3] == f.corners[0]) {
          outer.neighbors[k] = index;
        }
      }
      facets_.push_back(f);
    }
  }

  QuickHull finish() const {
    QuickHull hull;
    const Vec3 origin = points_[facets_.front().corners[0]];
    std::vector<char> is_corner(points_.size(), 0);
    for (const Facet& f : facets_) {
      if (!f.alive) continue;
      hull.triangles.push_back(f.corners);
      hull.planes.push_back({f.normal, f.offset, false});
      for (const int p : f.corners) is_corner[p] = 1;
      hull.volume +=
          (points_[f.corners[0]] - origin)
              .dot((points_[f.corners[1]] - origin).cross(points_[f.corners[2]] - origin)) /
          6;
    }
    for (std::size_t p = 0; p < points_.size(); ++p) {
      if (is_corner[p]) hull.corners.push_back(static_cast<int>(p));
    }
    return hull;
  }

  const std::vector<Vec3>& points_;
  double tolerance_;
  std::vector<Facet> facets_;
  std::vector<int> next_;     // [points] in the list of a facet, or -1
  std::vector<char> state_;   // [facets] seen from the present point
  std::vector<int> edge_to_;  // [points] the new facet whose horizon edge starts here, or -1
  std::vector<int> visible_;
  std::vector<Facet> fresh_;
  std::vector<std::array<int, 3>> horizon_;  // corner, corner, facet beyond
};

}  // namespace

std::optional<QuickHull> quick_hull(const std::vector<Vec3>& points, double tolerance) {
  return Builder(points, tolerance).build();
}

}  // namespace firn
