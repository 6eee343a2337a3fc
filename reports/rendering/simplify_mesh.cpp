#include "reports/rendering/simplify_mesh.h"

#include <algorithm>
#include <map>
#include <queue>
#include <set>

namespace firn {
namespace {

using Quadric = Eigen::Matrix4d;

// Squared distance (m^2) from the plane through `point`, times `weight`.
Quadric plane_quadric(const Vec3& normal, const Vec3& point, double weight) {
  Eigen::Vector4d p = Eigen::Vector4d::Zero();
  p << normal, -normal.dot(point);
  return weight * p * p.transpose();
}

struct Collapse {
  double cost;
  int from, to;
  int from_version, to_version;
  bool operator>(const Collapse& other) const { return cost > other.cost; }
};

class Simplifier {
 public:
  explicit Simplifier(const TriangleMesh& mesh)
      : vertices_(mesh.vertices),
        triangles_(mesh.triangles),
        alive_(mesh.triangles.size(), true),
        left_(mesh.triangles.size()),
        around_(mesh.vertices.size()),
        quadric_(mesh.vertices.size(), Quadric::Zero()),
        version_(mesh.vertices.size(), 0) {
    std::map<std::pair<int, int>, int> users;
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      const Vec3 normal = area_vector(triangles_[t]);
      const double twice_area = normal.norm();
      for (int k = 0; k < 3; ++k) {
        const int a = triangles_[t][k], b = triangles_[t][(k + 1) % 3];
        around_[a].insert(static_cast<int>(t));
        if (twice_area > 0)
          quadric_[a] += plane_quadric(normal / twice_area, vertices_[a], twice_area);
        ++users[std::minmax(a, b)];
      }
    }
    hold_free_edges(users);
    for (const auto& [edge, count] : users) offer(edge.first, edge.second);
  }

  TriangleMesh run(std::size_t wanted) {
    while (left_ > wanted && !queue_.empty()) {
      const Collapse c = queue_.top();
      queue_.pop();
      const bool current = c.from_version == version_[c.from] && c.to_version == version_[c.to];
      if (current && allowed(c.from, c.to)) collapse(c.from, c.to);
    }
    return result();
  }

 private:
  Vec3 area_vector(const std::array<int, 3>& t) const {
    return (vertices_[t[1]] - vertices_[t[0]]).cross(vertices_[t[2]] - vertices_[t[0]]);
  }

  // A plane through each free edge, across its triangle.
  void hold_free_edges(const std::map<std::pair<int, int>, int>& users) {
    for (const auto& t : triangles_) {
      for (int k = 0; k < 3; ++k) {
        const int a = t[k], b = t[(k + 1) % 3];
        if (users.at(std::minmax(a, b)) != 1) continue;
        const Vec3 along = vertices_[b] - vertices_[a];
        const Vec3 across = along.cross(area_vector(t));
        if (!(across.norm() > 0)) continue;
        const Quadric q =
            plane_quadric(across.normalized(), vertices_[a], 100 * along.squaredNorm());
        quadric_[a] += q;
        quadric_[b] += q;
      }
    }
  }

  void offer(int a, int b) {
    const Quadric q = quadric_[a] + quadric_[b];
    const auto cost = [&](int at) {
      const Eigen::Vector4d p = vertices_[at].homogeneous();
      return p.dot(q * p);
    };
    const double to_a = cost(a), to_b = cost(b);
    queue_.push({to_b, a, b, version_[a], version_[b]});
    queue_.push({to_a, b, a, version_[b], version_[a]});
  }

  std::set<int> neighbors(int v) const {
    std::set<int> all;
    for (const int t : around_[v]) all.insert(triangles_[t].begin(), triangles_[t].end());
    all.erase(v);
    return all;
  }

  // The surface stays a surface, and no triangle turns by more than about 80 degrees.
  bool allowed(int from, int to) const {
    std::size_t shared = 0;
    for (const int t : around_[from]) {
      std::array<int, 3> corners = triangles_[t];
      if (std::ranges::find(corners, to) != corners.end()) {
        ++shared;
        continue;
      }
      const Vec3 before = area_vector(corners);
      std::ranges::replace(corners, from, to);
      const Vec3 after = area_vector(corners);
      if (before.dot(after) <= 0.2 * before.norm() * after.norm()) return false;
    }
    const std::set<int> a = neighbors(from), b = neighbors(to);
    std::size_t common = 0;
    for (const int v : a) common += b.contains(v) ? 1 : 0;
    return shared > 0 && common == shared;
  }

  void collapse(int from, int to) {
    for (const int t : around_[from]) {
      std::array<int, 3>& corners = triangles_[t];
      if (std::ranges::find(corners, to) != corners.end()) {
        alive_[t] = false;
        --left_;
        for (const int v : corners)
          if (v != from) around_[v].erase(t);
      } else {
        std::ranges::replace(corners, from, to);
        around_[to].insert(t);
      }
    }
    around_[from].clear();
    quadric_[to] += quadric_[from];
    ++version_[from];
    ++version_[to];
    for (const int v : neighbors(to)) offer(to, v);
  }

  TriangleMesh result() const {
    TriangleMesh mesh;
    std::vector<int> index(vertices_.size(), -1);
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      if (!alive_[t]) continue;
      std::array<int, 3> corners{};
      for (int k = 0; k < 3; ++k) {
        int& at = index[triangles_[t][k]];
        if (at < 0) {
          at = static_cast<int>(mesh.vertices.size());
          mesh.vertices.push_back(vertices_[triangles_[t][k]]);
        }
        corners[k] = at;
      }
      mesh.triangles.push_back(corners);
    }
    return mesh;
  }

  std::vector<Vec3> vertices_;
  std::vector<std::array<int, 3>> triangles_;
  std::vector<bool> alive_;
  std::size_t left_;
  std::vector<std::set<int>> around_;  // triangles of each vertex
  std::vector<Quadric> quadric_;
  std::vector<int> version_;  // of each vertex: what the queue holds of an older one is void
  std::priority_queue<Collapse, std::vector<Collapse>, std::greater<>> queue_;
};

}  // namespace

TriangleMesh simplified_mesh(const TriangleMesh& mesh, std::size_t wanted) {
  if (mesh.triangles.size() <= wanted) return mesh;
  return Simplifier(mesh).run(wanted);
}

}  // namespace firn
