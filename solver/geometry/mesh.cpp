#include "firn/mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <unordered_map>

namespace firn {
namespace {

// An edge of a triangle, its ends in ascending order.
struct DirectedEdge {
  int low, high;
  bool ascending;  // the triangle runs from low to high

  auto key() const { return std::array<int, 2>{low, high}; }
};

std::vector<DirectedEdge> sorted_edges(const TriangleMesh& mesh) {
  std::vector<DirectedEdge> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (const auto& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), a < b});
    }
  }
  std::sort(edges.begin(), edges.end(),
            [](const auto& a, const auto& b) { return a.key() < b.key(); });
  return edges;
}

void count_edge_defects(const TriangleMesh& mesh, MeshDefects& defects) {
  const auto edges = sorted_edges(mesh);
  for (std::size_t i = 0, next; i < edges.size(); i = next) {
    next = i + 1;
    while (next < edges.size() && edges[next].key() == edges[i].key()) ++next;
    const auto uses = next - i;
    if (uses == 1) ++defects.open_edges;
    if (uses == 2 && edges[i].ascending == edges[i + 1].ascending) ++defects.flipped_edges;
    if (uses > 2) ++defects.nonmanifold_edges;
  }
}

int count_duplicates(const TriangleMesh& mesh) {
  auto corners = mesh.triangles;
  for (auto& t : corners) std::sort(t.begin(), t.end());
  std::sort(corners.begin(), corners.end());
  const auto first_duplicate = std::unique(corners.begin(), corners.end());
  return static_cast<int>(corners.end() - first_duplicate);
}

bool has_area(const TriangleMesh& mesh, const std::array<int, 3>& t) {
  const Vec3 ab = mesh.vertices[t[1]] - mesh.vertices[t[0]];
  const Vec3 ac = mesh.vertices[t[2]] - mesh.vertices[t[0]];
  const double longest = std::max({ab.squaredNorm(), ac.squaredNorm(), (ac - ab).squaredNorm()});
  return ab.cross(ac).norm() > 1e-12 * longest;
}

}  // namespace

MeshDefects inspect(const TriangleMesh& mesh) {
  MeshDefects defects;
  for (const Vec3& v : mesh.vertices) defects.non_finite |= !v.allFinite();
  count_edge_defects(mesh, defects);
  defects.duplicated = count_duplicates(mesh);
  if (defects.non_finite) return defects;
  for (const auto& t : mesh.triangles) defects.degenerate += !has_area(mesh, t);
  defects.inside_out = mass_properties(mesh).volume < 0;
  return defects;
}

std::string MeshDefects::to_message() const {
  std::string text;
  const auto add = [&text](const std::string& item) { text += (text.empty() ? "" : ", ") + item; };
  const auto count = [&add](int n, const char* one, const char* many) {
    if (n) add(std::to_string(n) + " " + (n == 1 ? one : many));
  };
  count(open_edges, "open edge", "open edges");
  count(nonmanifold_edges, "edge of more than two triangles", "edges of more than two triangles");
  count(flipped_edges, "edge between triangles that face opposite ways",
        "edges between triangles that face opposite ways");
  count(degenerate, "triangle of no area", "triangles of no area");
  count(duplicated, "repeated triangle", "repeated triangles");
  if (inside_out) add("inside out");
  if (non_finite) add("a coordinate is not a finite number");
  return text;
}

MassProperties mass_properties(const TriangleMesh& mesh) {
  MassProperties result;
  if (mesh.triangles.empty()) return result;
  // Signed tetrahedra from a point near the body, so that large coordinates do not cancel.
  const auto [lower, upper] = bounding_box(mesh);
  const Vec3 origin = (lower + upper) / 2;
  double volume = 0;
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();  // integral of x x^T
  for (const auto& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[t[0]] - origin;
    const Vec3 b = mesh.vertices[t[1]] - origin;
    const Vec3 c = mesh.vertices[t[2]] - origin;
    const Vec3 sum = a + b + c;
    const double six_volumes = a.dot(b.cross(c));
    volume += six_volumes / 6;
    first += six_volumes / 24 * sum;
    second += six_volumes / 120 *
              (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  result.volume = volume;
  if (volume == 0) return result;
  const Vec3 offset = first / volume;
  second -= volume * offset * offset.transpose();
  result.centroid = origin + offset;
  result.inertia = second.trace() * Mat3::Identity() - second;
  return result;
}

TriangleMesh box_mesh(const Vec3& size) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {  // bit k of i: upper side along axis k
    mesh.vertices.push_back(
        Vec3(i & 1 ? 0.5 : -0.5, i & 2 ? 0.5 : -0.5, i & 4 ? 0.5 : -0.5).cwiseProduct(size));
  }
  mesh.triangles = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
  return mesh;
}

std::array<Vec3, 2> bounding_box(const TriangleMesh& mesh) {
  if (mesh.vertices.empty()) return {Vec3::Zero(), Vec3::Zero()};
  Vec3 lower = mesh.vertices[0], upper = mesh.vertices[0];
  for (const Vec3& v : mesh.vertices) {
    lower = lower.cwiseMin(v);
    upper = upper.cwiseMax(v);
  }
  return {lower, upper};
}

namespace {

// Finds an earlier point within a tolerance through a grid of cells of that size.
class PointGrid {
 public:
  explicit PointGrid(double tolerance) : tolerance_(tolerance) {}

  // Index of the first stored point near `p`, or -1.
  int find(const Vec3& p, const std::vector<Vec3>& points) const {
    int best = -1;
    const int reach = tolerance_ > 0 ? 1 : 0;
    for (int dx = -reach; dx <= reach; ++dx) {
      for (int dy = -reach; dy <= reach; ++dy) {
        for (int dz = -reach; dz <= reach; ++dz) {
          const auto cell = cells_.find(key(p, dx, dy, dz));
          if (cell == cells_.end()) continue;
          for (const int i : cell->second) {
            if ((points[i] - p).norm() <= tolerance_ && (best < 0 || i < best)) best = i;
          }
        }
      }
    }
    return best;
  }

  void add(const Vec3& p, int index) { cells_[key(p, 0, 0, 0)].push_back(index); }

 private:
  // Cells may share a key: the distance decides.
  std::uint64_t key(const Vec3& p, int dx, int dy, int dz) const {
    const int shift[3] = {dx, dy, dz};
    std::uint64_t hash = 0;
    for (int k = 0; k < 3; ++k) {
      // Without tolerance the coordinate is its own cell; adding zero makes -0 equal to +0.
      const double cell = tolerance_ > 0 ? std::floor(p[k] / tolerance_) + shift[k] : p[k] + 0.0;
      hash = (hash ^ std::hash<double>{}(cell)) * 0x9E3779B97F4A7C15u;
      hash ^= hash >> 29;
    }
    return hash;
  }

  double tolerance_;
  std::unordered_map<std::uint64_t, std::vector<int>> cells_;
};

}  // namespace

TriangleMesh weld(const TriangleMesh& mesh, double tolerance) {
  TriangleMesh result;
  PointGrid grid(tolerance);
  std::vector<int> index(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Vec3& p = mesh.vertices[i];
    index[i] = grid.find(p, result.vertices);
    if (index[i] >= 0) continue;
    index[i] = static_cast<int>(result.vertices.size());
    result.vertices.push_back(p);
    grid.add(p, index[i]);
  }
  for (const auto& t : mesh.triangles) {
    const std::array<int, 3> welded = {index[t[0]], index[t[1]], index[t[2]]};
    if (welded[0] != welded[1] && welded[1] != welded[2] && welded[2] != welded[0]) {
      result.triangles.push_back(welded);
    }
  }
  return result;
}

Vec3 area_normal(const TriangleMesh& mesh, std::size_t triangle) {
  const auto& t = mesh.triangles[triangle];
  const Vec3& a = mesh.vertices[t[0]];
  return (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a);
}

TriangleMesh subdivided(const TriangleMesh& mesh, double edge) {
  TriangleMesh out;
  out.vertices = mesh.vertices;
  std::map<std::pair<int, int>, int> middles;
  const auto length = [&](int a, int b) { return (out.vertices[b] - out.vertices[a]).norm(); };
  // The longest edge is cut first, the one of lower vertices among equals: both of its triangles
  // cut it there.
  const auto cut = [&](auto&& self, int a, int b, int c) -> void {
    const double bc = length(b, c), ca = length(c, a), ab = length(a, b);
    const double longest = std::max({ab, bc, ca});
    if (longest <= edge) {
      out.triangles.push_back({a, b, c});
      return;
    }
    if (ab < longest) return bc == longest ? self(self, b, c, a) : self(self, c, a, b);
    const auto [middle, is_new] =
        middles.try_emplace(std::minmax(a, b), static_cast<int>(out.vertices.size()));
    const Vec3 between = 0.5 * (out.vertices[a] + out.vertices[b]);
    if (is_new) out.vertices.push_back(between);
    const int m = middle->second;
    self(self, a, m, c);
    self(self, m, b, c);
  };
  for (const auto& [a, b, c] : mesh.triangles) cut(cut, a, b, c);
  return out;
}

}  // namespace firn
