#include "experiments/meshes/wall_solids.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

namespace firn {
namespace {

using Edge = std::pair<int, int>;  // vertices, in the direction of the triangle that owns it

// A sharper fold than this has no bisector worth the name: about 168 degrees between the normals.
constexpr double kSharpestFold = -0.98;

Vec3 face_normal(const TriangleMesh& mesh, const std::array<int, 3>& t) {
  const Vec3& a = mesh.vertices[t[0]];
  return (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).normalized();
}

double size_of(const TriangleMesh& mesh) {
  const auto [lower, upper] = bounding_box(mesh);
  return (upper - lower).norm();
}

bool is_convex(const TriangleMesh& mesh) {
  const double tolerance = 1e-7 * size_of(mesh);
  return std::ranges::all_of(mesh.triangles, [&](const std::array<int, 3>& t) {
    const Vec3 n = face_normal(mesh, t);
    const double offset = n.dot(mesh.vertices[t[0]]) + tolerance;
    return std::ranges::all_of(mesh.vertices, [&](const Vec3& v) { return n.dot(v) <= offset; });
  });
}

void refuse_defects(const MeshDefects& found) {
  MeshDefects fatal;
  fatal.flipped_edges = found.flipped_edges;
  fatal.degenerate = found.degenerate;
  fatal.duplicated = found.duplicated;
  fatal.non_finite = found.non_finite;
  if (!fatal.is_valid()) {
    throw InputError(fmt::format("the surface has {}; expected triangles that face the same way",
                                 fatal.to_message()));
  }
}

// The one triangle on the other side of each edge.
std::map<Edge, int> owners(const TriangleMesh& mesh) {
  std::map<Edge, int> count, owner;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& t = mesh.triangles[i];
    for (int k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(t[k], t[(k + 1) % 3]);
      ++count[{low, high}];
      owner[{t[k], t[(k + 1) % 3]}] = static_cast<int>(i);
    }
  }
  std::erase_if(owner, [&](const auto& entry) {
    const auto [low, high] = std::minmax(entry.first.first, entry.first.second);
    return count[{low, high}] != 2;
  });
  return owner;
}

// A plane polygon of the surface: triangles of one plane whose union is convex.
struct Facet {
  Vec3 normal = Vec3::Zero();  // unit
  double offset = 0;
  std::vector<int> triangles;
};

// One straight side of a facet's outline, and what is on the other side of it.
struct FacetSide {
  int from = 0, to = 0;        // vertices
  std::optional<Vec3> beyond;  // normal of the facets there; none: a free edge
};

bool is_same_normal(const std::optional<Vec3>& a, const std::optional<Vec3>& b) {
  constexpr double kSame = 1e-5;
  return a.has_value() == b.has_value() && (!a || (*a - *b).norm() < kSame);
}

// Merges triangles to facets, so that contact does not depend on how a plane surface was meshed.
class FacetMaker {
 public:
  explicit FacetMaker(const TriangleMesh& mesh)
      : mesh_(mesh),
        owner_(owners(mesh)),
        // Corners of a plane surface in a file of single precision are off by less.
        tolerance_(2e-7 * size_of(mesh)),
        group_of_(mesh.triangles.size(), -1) {
    for (const auto& t : mesh.triangles) normals_.push_back(face_normal(mesh, t));
    find_planes();
  }

  std::vector<Facet> make() {
    std::vector<Facet> facets;
    for (const std::vector<int>& group : groups_) {
      // The whole plane at once, if it is convex; else piece by piece.
      if (sides_of(group)) {
        facets.push_back(facet(group));
        continue;
      }
      for (std::vector<int>& part : merge(group)) facets.push_back(facet(std::move(part)));
    }
    // In the order of the mesh.
    std::ranges::sort(facets, {}, [](const Facet& f) { return std::ranges::min(f.triangles); });
    return facets;
  }

  // The sides of the union of triangles of one plane, counter-clockwise. Nothing if it is not
  // convex, or if a straight side has different facets beyond it: one plane cannot bound the prism
  // to all of them.
  std::optional<std::vector<FacetSide>> sides_of(const std::vector<int>& triangles) const {
    std::map<int, FacetSide> next;  // by the first vertex
    std::set<Edge> inside;
    for (const int t : triangles) {
      for (const Edge& e : edges_of(t)) inside.insert(e);
    }
    for (const Edge& e : inside) {
      const auto [a, b] = e;
      if (inside.contains({b, a})) continue;
      if (!next.emplace(a, FacetSide{a, b, beyond(e)}).second) return std::nullopt;
    }
    std::vector<FacetSide> loop;
    for (auto it = next.begin(); it != next.end(); it = next.find(loop.back().to)) {
      loop.push_back(it->second);
      next.erase(it);
    }
    if (!next.empty() || loop.size() < 3) return std::nullopt;  // a hole
    // A triangle is convex, also one that is narrower than the tolerance.
    if (triangles.size() == 1) return loop;
    return straightened(loop, planes_[group_of_[triangles[0]]].normal);
  }

 private:
  std::array<Edge, 3> edges_of(int t) const {
    const auto& [a, b, c] = mesh_.triangles[t];
    return {Edge{a, b}, Edge{b, c}, Edge{c, a}};
  }

  // The triangle on the other side of an edge; -1: none.
  int across(const Edge& e) const {
    const auto it = owner_.find({e.second, e.first});
    return it == owner_.end() ? -1 : it->second;
  }

  std::optional<Vec3> beyond(const Edge& e) const {
    const int other = across(e);
    if (other < 0) return std::nullopt;
    const Vec3& n = planes_[group_of_[other]].normal;
    if (planes_[group_of_[owner_.at(e)]].normal.dot(n) <= kSharpestFold) return std::nullopt;
    return n;
  }

  struct Plane {
    Vec3 normal = Vec3::Zero();  // unit
    double offset = 0;
    double height(const Vec3& x) const { return std::abs(normal.dot(x) - offset); }
  };

  Vec3 area_vector(int t) const {
    const auto& [a, b, c] = mesh_.triangles[t];
    const Vec3& from = mesh_.vertices[a];
    return 0.5 * (mesh_.vertices[b] - from).cross(mesh_.vertices[c] - from);
  }

  bool is_in_plane(int t, const Plane& plane) const {
    constexpr double kSameNormal = 0.999;
    return normals_[t].dot(plane.normal) > kSameNormal &&
           std::ranges::all_of(mesh_.triangles[t], [&](int v) {
             return plane.height(mesh_.vertices[v]) <= tolerance_;
           });
  }

  // Connected triangles whose corners are in one plane, that of the largest of them, or the mean of
  // all if that holds for it.
  void find_planes() {
    std::vector<double> area;
    std::vector<int> order;
    for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
      area.push_back(area_vector(static_cast<int>(i)).norm());
      order.push_back(static_cast<int>(i));
    }
    std::ranges::stable_sort(order, std::greater{}, [&](int i) { return area[i]; });
    for (const int seed : order) {
      if (group_of_[seed] >= 0) continue;
      // Small triangles of single precision are turned by more than a large plane allows.
      if (grow(seed, true) || grow(seed, false)) continue;
    }
  }

  // Makes a group of the triangles around the seed; with `mean`, the plane follows the mean of
  // those found so far. False, and no group, if one of them is not in the final plane.
  bool grow(int seed, bool mean) {
    const int number = static_cast<int>(groups_.size());
    const Vec3& n = normals_[seed];
    Plane plane{n, n.dot(mesh_.vertices[mesh_.triangles[seed][0]])};
    Vec3 sum = Vec3::Zero(), first = Vec3::Zero();
    double weight = 0;
    std::vector<int> group = {seed};
    group_of_[seed] = number;
    for (std::size_t i = 0; i < group.size(); ++i) {
      const int t = group[i];
      if (mean) {
        const Vec3 area = area_vector(t);
        sum += area;
        weight += area.norm();
        for (const int v : mesh_.triangles[t]) first += area.norm() / 3 * mesh_.vertices[v];
        plane.normal = sum.normalized();
        plane.offset = plane.normal.dot(first) / weight;
      }
      for (const Edge& e : edges_of(t)) {
        const int other = across(e);
        if (other < 0 || group_of_[other] >= 0 || !is_in_plane(other, plane)) continue;
        group_of_[other] = number;
        group.push_back(other);
      }
    }
    if (!std::ranges::all_of(group, [&](int t) { return is_in_plane(t, plane); })) {
      for (const int t : group) group_of_[t] = -1;
      return false;
    }
    groups_.push_back(std::move(group));
    planes_.push_back(plane);
    return true;
  }

  std::optional<std::vector<FacetSide>> straightened(const std::vector<FacetSide>& loop,
                                                     const Vec3& normal) const {
    // m, of b from the line a c; positive: the outline turns to the left at b.
    const auto bulge = [&](int a, int b, int c) {
      const Vec3 chord = mesh_.vertices[c] - mesh_.vertices[a];
      return (mesh_.vertices[b] - mesh_.vertices[a]).cross(chord).dot(normal) / chord.norm();
    };
    // Starts at the sharpest corner.
    std::size_t start = 0;
    double most = 0;
    for (std::size_t k = 0; k < loop.size(); ++k) {
      const double here =
          bulge(loop[(k + loop.size() - 1) % loop.size()].from, loop[k].from, loop[k].to);
      if (here > most) start = k;
      most = std::max(most, here);
    }
    std::vector<FacetSide> sides;
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const FacetSide& next = loop[(start + i) % loop.size()];
      const double here = sides.empty() ? 0 : bulge(sides.back().from, next.from, next.to);
      if (here < -tolerance_) return std::nullopt;
      if (here > tolerance_ || sides.empty()) {
        sides.push_back(next);
      } else {
        if (!is_same_normal(sides.back().beyond, next.beyond)) return std::nullopt;
        sides.back().to = next.to;
      }
    }
    if (sides.size() < 3 || sides.size() + 2 > kMaxInternalFaces) return std::nullopt;
    return sides;
  }

  // Convex unions of triangles of one plane: neighbors are merged as long as that gives one, the
  // longest common edges first (after Hertel and Mehlhorn 1983).
  std::vector<std::vector<int>> merge(const std::vector<int>& group) const {
    std::vector<std::pair<double, Edge>> seams;
    for (const int t : group) {
      for (const Edge& e : edges_of(t)) {
        const int other = across(e);
        if (e.first < e.second && other >= 0 && group_of_[other] == group_of_[t])
          seams.emplace_back((mesh_.vertices[e.first] - mesh_.vertices[e.second]).norm(), e);
      }
    }
    std::ranges::stable_sort(seams, std::greater{}, [](const auto& s) { return s.first; });
    std::map<int, int> part_of;
    std::vector<std::vector<int>> parts;
    for (const int t : group) {
      part_of[t] = static_cast<int>(parts.size());
      parts.push_back({t});
    }
    for (bool changed = true; changed;) {
      changed = false;
      for (const auto& [length, e] : seams) {
        const int a = part_of[owner_.at(e)], b = part_of[across(e)];
        if (a == b) continue;
        std::vector<int> both = parts[a];
        both.insert(both.end(), parts[b].begin(), parts[b].end());
        if (!sides_of(both)) continue;
        for (const int t : parts[b]) part_of[t] = a;
        parts[a] = std::move(both);
        parts[b].clear();
        changed = true;
      }
    }
    std::erase_if(parts, [](const std::vector<int>& part) { return part.empty(); });
    return parts;
  }

  Facet facet(std::vector<int> triangles) const {
    const Plane& plane = planes_[group_of_[triangles[0]]];
    return {plane.normal, plane.offset, std::move(triangles)};
  }

  const TriangleMesh& mesh_;
  std::map<Edge, int> owner_;
  double tolerance_;                      // m, of a plane
  std::vector<Vec3> normals_;             // of triangles
  std::vector<int> group_of_;             // of triangles; -1: none yet
  std::vector<std::vector<int>> groups_;  // triangles of one plane, connected
  std::vector<Plane> planes_;             // of groups
};

// m, the least height of a triangle.
double least_height(const TriangleMesh& mesh, std::size_t triangle) {
  const std::array<int, 3>& t = mesh.triangles[triangle];
  double longest = 0;
  for (int k = 0; k < 3; ++k)
    longest = std::max(longest, (mesh.vertices[t[(k + 1) % 3]] - mesh.vertices[t[k]]).norm());
  return area_normal(mesh, triangle).norm() / longest;
}

ConvexPart prism(const TriangleMesh& mesh, const Facet& facet, const std::vector<FacetSide>& sides,
                 double thickness) {
  const Vec3& n = facet.normal;
  std::vector<HalfSpace> faces = {{n, facet.offset, false}, {-n, thickness - facet.offset, false}};
  for (const FacetSide& s : sides) {
    const Vec3 along = (mesh.vertices[s.to] - mesh.vertices[s.from]).normalized();
    HalfSpace side{along.cross(n).normalized(), 0, false};
    if (s.beyond) {
      side.normal = along.cross(n + *s.beyond).normalized();
      side.internal = true;
    }
    side.offset = side.normal.dot(mesh.vertices[s.from]);
    faces.push_back(side);
  }
  return convex_part(faces, 0);
}

}  // namespace

std::vector<ConvexPart> wall_solids(const TriangleMesh& mesh, double thickness) {
  const MeshDefects defects = inspect(mesh);
  refuse_defects(defects);
  if (defects.is_valid() && is_convex(mesh)) {
    return {convex_part(convex_hull(mesh.vertices), 0)};
  }
  FacetMaker maker(mesh);
  std::vector<ConvexPart> parts;
  for (const Facet& facet : maker.make()) {
    try {
      parts.push_back(prism(mesh, facet, maker.sides_of(facet.triangles).value(), thickness));
    } catch (const InputError& error) {
      const std::size_t first = static_cast<std::size_t>(facet.triangles[0]);
      const Vec3& at = mesh.vertices[mesh.triangles[first][0]];
      throw InputError(fmt::format(
          "triangle {} at ({:.4g}, {:.4g}, {:.4g}) m, {:.2g} m wide, makes no wall with its "
          "neighbors: {}",
          first + 1, at.x(), at.y(), at.z(), least_height(mesh, first), error.what()));
    }
  }
  return parts;
}

std::vector<HalfSpace> box_half_spaces(const Vec3& size) {
  std::vector<HalfSpace> sides;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      sides.push_back({sign * Vec3::Unit(axis), size[axis] / 2, false});
    }
  }
  return sides;
}

}  // namespace firn
