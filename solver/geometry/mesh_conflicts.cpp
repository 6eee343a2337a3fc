#include "firn/mesh_conflicts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

namespace firn {
namespace {

constexpr double kTouch = 1e-6;      // of the diagonal: an overlap so shallow is a touch
constexpr std::size_t kMost = 1000;  // conflicts of a kind, then the search stops
constexpr int kMostShells = 100;     // the same of shells inside others or inverted

struct Box {
  Vec3 low = Vec3::Constant(INFINITY), high = Vec3::Constant(-INFINITY);
  void add(const Vec3& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  void add(const Box& b) {
    low = low.cwiseMin(b.low);
    high = high.cwiseMax(b.high);
  }
  bool holds(const Box& b) const {
    return (low.array() <= b.low.array()).all() && (b.high.array() <= high.array()).all();
  }
  bool overlaps(const Box& b) const {
    return (low.array() <= b.high.array()).all() && (b.low.array() <= high.array()).all();
  }
};

// A tree of bounding boxes: node n has the children 2 n + 1 and 2 n + 2, each with half of its
// triangles. AabbTree (solver/collision/broadphase.h) does not replace it: the order of the pairs
// decides which example a message names, and a query here neither allocates memory nor sorts.
class TriangleTree {
 public:
  explicit TriangleTree(std::vector<Box> boxes) : boxes_(std::move(boxes)), order_(boxes_.size()) {
    std::iota(order_.begin(), order_.end(), 0);
    if (!order_.empty()) build(0, 0, order_.size());
  }

  // Calls f(i, j) with i < j once for each pair of boxes that overlap.
  template <typename F>
  void pairs(F f) const {
    for (int i = 0; i < static_cast<int>(boxes_.size()); ++i) {
      if (!order_.empty()) visit(0, 0, order_.size(), i, f);
    }
  }

 private:
  static constexpr std::size_t kLeaf = 4;

  void build(std::size_t node, std::size_t first, std::size_t last) {
    Box all;
    for (std::size_t i = first; i < last; ++i) all.add(boxes_[order_[i]]);
    if (nodes_.size() <= node) nodes_.resize(node + 1);
    nodes_[node] = all;
    if (last - first <= kLeaf) return;
    int axis = 0;
    (all.high - all.low).maxCoeff(&axis);
    const std::size_t middle = (first + last) / 2;
    const auto center = [&](int i) { return boxes_[i].low[axis] + boxes_[i].high[axis]; };
    std::nth_element(order_.begin() + static_cast<std::ptrdiff_t>(first),
                     order_.begin() + static_cast<std::ptrdiff_t>(middle),
                     order_.begin() + static_cast<std::ptrdiff_t>(last), [&](int a, int b) {
                       return std::pair(center(a), a) < std::pair(center(b), b);
                     });
    build(2 * node + 1, first, middle);
    build(2 * node + 2, middle, last);
  }

  template <typename F>
  void visit(std::size_t node, std::size_t first, std::size_t last, int i, F& f) const {
    if (!nodes_[node].overlaps(boxes_[i])) return;
    if (last - first <= kLeaf) {
      for (std::size_t k = first; k < last; ++k) {
        if (order_[k] > i && boxes_[order_[k]].overlaps(boxes_[i])) f(i, order_[k]);
      }
      return;
    }
    const std::size_t middle = (first + last) / 2;
    visit(2 * node + 1, first, middle, i, f);
    visit(2 * node + 2, middle, last, i, f);
  }

  std::vector<Box> boxes_, nodes_;
  std::vector<int> order_;
};

// Triangles as planes, with the triangle on the other side of each edge.
class Surface {
 public:
  explicit Surface(const TriangleMesh& mesh) {
    const auto [low, high] = bounding_box(mesh);
    touch_ = kTouch * (high - low).norm();
    const int count = static_cast<int>(mesh.triangles.size());
    neighbors_.assign(mesh.triangles.size(), {-1, -1, -1});
    struct Side {
      int low, high, triangle, edge;
      auto key() const { return std::tuple(low, high, triangle, edge); }
    };
    std::vector<Side> sides;
    for (int i = 0; i < count; ++i) {
      const auto& t = mesh.triangles[i];
      corners_.push_back({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
      for (int k = 0; k < 3; ++k) {
        const int a = t[k], b = t[(k + 1) % 3];
        sides.push_back({std::min(a, b), std::max(a, b), i, k});
      }
      const Vec3 n = (corner(i, 1) - corner(i, 0)).cross(corner(i, 2) - corner(i, 0));
      normals_.push_back(n.norm() > 0 ? Vec3(n.normalized()) : Vec3(Vec3::Zero()));
    }
    std::sort(sides.begin(), sides.end(),
              [](const Side& a, const Side& b) { return a.key() < b.key(); });
    shells_.resize(mesh.triangles.size());
    std::iota(shells_.begin(), shells_.end(), 0);
    for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
      const Side &a = sides[i], &b = sides[i + 1];
      if (a.low != b.low || a.high != b.high) continue;
      neighbors_[a.triangle][a.edge] = b.triangle;
      neighbors_[b.triangle][b.edge] = a.triangle;
      shells_[std::max(root(a.triangle), root(b.triangle))] =
          std::min(root(a.triangle), root(b.triangle));
    }
    for (int i = 0; i < count; ++i) shells_[i] = root(i);
  }

  const Vec3& corner(int triangle, int k) const { return corners_[triangle][k == 3 ? 0 : k]; }
  Vec3 center(int t) const { return (corner(t, 0) + corner(t, 1) + corner(t, 2)) / 3; }
  // The first triangle of the shell.
  int shell(int triangle) const { return shells_[triangle]; }
  Box box(int triangle) const {
    Box b;
    for (int k = 0; k < 3; ++k) b.add(corner(triangle, k));
    return b;
  }

  // A point at which two triangles pass through each other, or lie on each other facing one way.
  std::optional<Vec3> crossing(int a, int b) const {
    const PlaneSides of_b = sides(b, a);
    if (!of_b.above && !of_b.below) return on_each_other(a, b);
    if (!of_b.above || !of_b.below) return std::nullopt;
    const PlaneSides of_a = sides(a, b);
    if (!of_a.above || !of_a.below) return std::nullopt;
    for (const auto& [t, other] : {std::pair(a, b), std::pair(b, a)}) {
      for (int k = 0; k < 3; ++k) {
        if (const auto p = crossing(corner(t, k), corner(t, k + 1), other)) return p;
      }
    }
    return on_each_other(a, b);
  }

  // -1, 0 or 1: below, on or above the triangle's plane.
  int side(const Vec3& p, int triangle) const {
    const double d = normals_[triangle].dot(p - corner(triangle, 0));
    return d > touch_ ? 1 : d < -touch_ ? -1 : 0;
  }

 private:
  int root(int i) {
    while (shells_[i] != i) i = shells_[i] = shells_[shells_[i]];
    return i;
  }

  // On which sides of a plane a triangle has corners.
  struct PlaneSides {
    bool above = false, below = false;
  };
  PlaneSides sides(int triangle, int plane) const {
    PlaneSides s;
    for (int k = 0; k < 3; ++k) {
      const int at = side(corner(triangle, k), plane);
      s.above |= at > 0;
      s.below |= at < 0;
    }
    return s;
  }

  // A segment that crosses a surface at an edge crosses the planes of both its triangles the same
  // way.
  std::optional<Vec3> crossing(const Vec3& p, const Vec3& q, int triangle) const {
    const Vec3& n = normals_[triangle];
    const int from = side(p, triangle), to = side(q, triangle);
    if (from * to >= 0) return std::nullopt;
    const double above = n.dot(p - corner(triangle, 0)), below = n.dot(q - corner(triangle, 0));
    const Vec3 x = p + above / (above - below) * (q - p);
    for (int k = 0; k < 3; ++k) {
      const Vec3 along = (corner(triangle, k + 1) - corner(triangle, k)).normalized();
      const double inside = n.cross(along).dot(x - corner(triangle, k));
      if (inside > touch_) continue;
      const int next = neighbors_[triangle][k];
      if (inside < -touch_ || next < 0 || side(p, next) != from || side(q, next) != to)
        return std::nullopt;
    }
    return x;
  }

  std::optional<Vec3> on_each_other(int a, int b) const {
    if (normals_[a].dot(normals_[b]) < 0.5) return std::nullopt;
    for (const int t : {a, b}) {
      for (int k = 0; k < 3; ++k) {
        const int other = t == a ? b : a;
        const Vec3 along = corner(t, k + 1) - corner(t, k);
        const Vec3 in = normals_[t].cross(along);
        const Vec3& foot = corner(t, k);
        const double reach =
            std::max({in.dot(corner(other, 0) - foot), in.dot(corner(other, 1) - foot),
                      in.dot(corner(other, 2) - foot)});
        if (reach <= 0 || reach * reach <= touch_ * touch_ * along.squaredNorm())
          return std::nullopt;
      }
    }
    // The center of the part of the one triangle that lies over the other.
    std::vector<Vec3> region = {corner(a, 0), corner(a, 1), corner(a, 2)};
    for (int k = 0; k < 3 && !region.empty(); ++k) {
      const Vec3 in = normals_[b].cross(corner(b, k + 1) - corner(b, k));
      std::vector<Vec3> kept;
      for (std::size_t i = 0; i < region.size(); ++i) {
        const Vec3 &p = region[i], &q = region[(i + 1) % region.size()];
        const double dp = in.dot(p - corner(b, k)), dq = in.dot(q - corner(b, k));
        if (dp >= 0) kept.push_back(p);
        if (dp * dq < 0) kept.push_back(p + dp / (dp - dq) * (q - p));
      }
      region = std::move(kept);
    }
    if (region.empty()) return std::nullopt;
    Vec3 sum = Vec3::Zero();
    for (const Vec3& p : region) sum += p;
    return Vec3(sum / static_cast<double>(region.size()));
  }

  std::vector<std::array<Vec3, 3>> corners_;
  double touch_ = 0;
  std::vector<Vec3> normals_;
  std::vector<std::array<int, 3>> neighbors_;  // over the edge that begins at corner k; -1: none
  std::vector<int> shells_;
};

struct Shell {
  std::vector<int> triangles;
  Box box;
  double volume = 0;  // m^3, below zero where it faces inwards
};

// How often a closed shell that faces outwards surrounds a point: 0, 1, or a half on the surface.
double winding(const Surface& surface, const Shell& shell, const Vec3& p) {
  double angle = 0;
  for (const int t : shell.triangles) {
    const Vec3 a = surface.corner(t, 0) - p, b = surface.corner(t, 1) - p,
               c = surface.corner(t, 2) - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    const double flat = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    if (flat <= 0 && surface.side(p, t) == 0) return 0.5;
    angle += 2 * std::atan2(a.dot(b.cross(c)), flat);
  }
  return angle / (4 * EIGEN_PI);
}

// Whether a shell that does not cross another one is inside it. A center on the other's surface
// says nothing.
bool is_inside(const Surface& surface, const Shell& shell, const Shell& other) {
  constexpr int kTries = 32;
  const int step = std::max(1, static_cast<int>(shell.triangles.size()) / kTries);
  for (int i = 0; i < static_cast<int>(shell.triangles.size()); i += step) {
    const double turns = std::abs(winding(surface, other, surface.center(shell.triangles[i])));
    if (turns > 0.75) return true;
    if (turns < 0.25) return false;
  }
  return false;
}

using ShellPair = std::pair<int, int>;  // first triangles, ascending

// Adds an example of a conflict if there is none of its kind yet.
void add_example(MeshConflicts& result, const MeshConflict& found) {
  const bool known = std::ranges::any_of(
      result.examples, [&](const MeshConflict& c) { return c.kind == found.kind; });
  if (!known) result.examples.push_back(found);
}

// Counts the pairs of triangles of one shell that cross. Returns the pairs of shells that overlap.
std::set<ShellPair> find_crossings(const Surface& surface, const std::vector<Box>& boxes,
                                   MeshConflicts& result) {
  std::set<ShellPair> overlapping;
  TriangleTree(boxes).pairs([&](int i, int j) {
    if (result.intersections + overlapping.size() >= kMost) return;
    const int a = surface.shell(i), b = surface.shell(j);
    const ShellPair shells(std::min(a, b), std::max(a, b));
    const bool same = shells.first == shells.second;
    if (!same && overlapping.contains(shells)) return;
    const std::optional<Vec3> place = surface.crossing(i, j);
    if (!place) return;
    if (same) ++result.intersections;
    if (!same) overlapping.insert(shells);
    const auto kind = same ? MeshConflict::Kind::crossing : MeshConflict::Kind::overlapping;
    add_example(result, {kind, i, j, *place});
  });
  result.overlapping_shells = static_cast<int>(overlapping.size());
  return overlapping;
}

// In order of their first triangles.
std::vector<Shell> shells_of(const Surface& surface, const std::vector<Box>& boxes) {
  std::vector<Shell> shells;
  std::vector<int> index(boxes.size(), -1);
  const Vec3 origin = boxes.empty() ? Vec3(Vec3::Zero()) : surface.corner(0, 0);
  for (int i = 0; i < static_cast<int>(boxes.size()); ++i) {
    int& at = index[surface.shell(i)];
    if (at < 0) {
      at = static_cast<int>(shells.size());
      shells.emplace_back();
    }
    Shell& shell = shells[at];
    shell.triangles.push_back(i);
    shell.box.add(boxes[i]);
    shell.volume += (surface.corner(i, 0) - origin)
                        .dot((surface.corner(i, 1) - origin).cross(surface.corner(i, 2) - origin)) /
                    6;
  }
  return shells;
}

// Counts the closed shells that face the wrong way. Outside all other shells a shell faces
// outwards, inside one that does it is a cavity.
void find_misplaced_shells(const Surface& surface, const std::vector<Shell>& shells,
                           const std::set<ShellPair>& overlapping, MeshConflicts& result) {
  for (const Shell& shell : shells) {
    if (result.nested_shells + result.inverted_shells >= kMostShells) break;
    int depth = 0, around = -1;
    for (const Shell& other : shells) {
      if (&other == &shell || !other.box.holds(shell.box)) continue;
      const int first = shell.triangles[0], other_first = other.triangles[0];
      if (overlapping.contains(std::minmax(first, other_first))) continue;
      if (!is_inside(surface, shell, other)) continue;
      depth += other.volume > 0 ? 1 : -1;
      around = other_first;
    }
    const bool outwards = shell.volume > 0;
    if (depth == (outwards ? 0 : 1)) continue;
    ++(outwards ? result.nested_shells : result.inverted_shells);
    const auto kind = outwards ? MeshConflict::Kind::nested : MeshConflict::Kind::inverted;
    const int first = shell.triangles[0];
    add_example(result, {kind, first, around, surface.center(first)});
  }
}

}  // namespace

MeshConflicts find_conflicts(const TriangleMesh& mesh) {
  MeshConflicts result;
  const Surface surface(mesh);
  std::vector<Box> boxes;
  for (int i = 0; i < static_cast<int>(mesh.triangles.size()); ++i) boxes.push_back(surface.box(i));
  const std::set<ShellPair> overlapping = find_crossings(surface, boxes, result);
  const MeshDefects defects = inspect(mesh);
  if (defects.open_edges || defects.nonmanifold_edges || defects.flipped_edges) return result;
  find_misplaced_shells(surface, shells_of(surface, boxes), overlapping, result);
  return result;
}

std::string MeshConflicts::to_message() const {
  std::string text;
  for (const MeshConflict& c : examples) {
    const auto item = [&](int count, const char* one, const char* many) {
      text += fmt::format("{}{} {} (triangle{} {}", text.empty() ? "" : ", ", count,
                          count == 1 ? one : many, c.other < 0 ? "" : "s", c.triangle + 1);
      if (c.other >= 0) text += fmt::format(" and {}", c.other + 1);
      text += fmt::format(" at {:.4g} {:.4g} {:.4g} mm)", 1e3 * c.position.x(),
                          1e3 * c.position.y(), 1e3 * c.position.z());
    };
    switch (c.kind) {
      case MeshConflict::Kind::crossing:
        item(intersections, "pair of triangles that cross", "pairs of triangles that cross");
        break;
      case MeshConflict::Kind::overlapping:
        item(overlapping_shells, "pair of shells that overlap", "pairs of shells that overlap");
        break;
      case MeshConflict::Kind::nested:
        item(nested_shells, "shell inside another one", "shells inside others");
        break;
      case MeshConflict::Kind::inverted:
        item(inverted_shells, "shell that faces inwards", "shells that face inwards");
        break;
    }
  }
  return text;
}

}  // namespace firn
