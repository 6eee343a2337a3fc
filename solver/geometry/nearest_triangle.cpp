#include "solver/geometry/nearest_triangle.h"

#include <algorithm>
#include <limits>
#include <map>
#include <unsupported/Eigen/BVH>

namespace firn {

namespace {

using AlignedBox = Eigen::AlignedBox3d;

struct Triangle {
  int index;
  Vec3 corner[3];
  Vec3 normal;  // unit
};
// Found by argument-dependent lookup from Eigen's tree.
AlignedBox bounding_box(const Triangle* t) {
  AlignedBox box(t->corner[0]);
  box.extend(t->corner[1]);
  box.extend(t->corner[2]);
  return box;
}

double squared_distance(const Vec3& p, const Triangle& t) {
  double nearest = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const Vec3 &a = t.corner[k], ab = t.corner[(k + 1) % 3] - a;
    if (t.normal.cross(ab).dot(p - a) >= 0) continue;  // inside of this edge
    const double along = std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (p - a - along * ab).squaredNorm());
  }
  if (nearest < std::numeric_limits<double>::infinity()) return nearest;
  const double height = t.normal.dot(p - t.corner[0]);
  return height * height;
}

using Tree = Eigen::KdBVH<double, 3, const Triangle*>;

// The nearest triangle so far. Which one it is in the end does not depend on the order in which
// they come: all within the rounding of the nearest distance are looked at, and the first number
// wins.
struct Search {
  Vec3 place, out;
  int index = -1;
  double distance = std::numeric_limits<double>::infinity();  // m^2

  void look_at(const Triangle& t) {
    if (t.normal.dot(out) < 0) return;
    const double d = squared_distance(place, t);
    if (d < distance || (d == distance && t.index < index)) {
      distance = d;
      index = t.index;
    }
  }
  bool may_hold(double box_distance) const { return box_distance <= distance * (1 + 1e-12); }

  // Nearer boxes first. A tree halves its triangles: it is no deeper than the stack.
  void descend(const Tree& tree) {
    struct Node {
      int index;
      double distance;  // m^2
    };
    Node stack[64];
    int size = 0;
    stack[size++] = {tree.getRootIndex(), 0};
    while (size > 0) {
      const Node node = stack[--size];
      if (!may_hold(node.distance)) continue;
      Tree::VolumeIterator box = nullptr, last_box = nullptr;
      Tree::ObjectIterator triangle = nullptr, last_triangle = nullptr;
      tree.getChildren(node.index, box, last_box, triangle, last_triangle);
      for (; triangle != last_triangle; ++triangle) look_at(**triangle);
      const int first = size;
      for (; box != last_box; ++box)
        stack[size++] = {*box, tree.getVolume(*box).squaredExteriorDistance(place)};
      if (size == first + 2 && stack[first].distance < stack[first + 1].distance)
        std::swap(stack[first], stack[first + 1]);
    }
  }
};

}  // namespace

struct NearestTriangle::Impl {
  std::vector<Triangle> triangles;
  Tree tree;
};

NearestTriangle::NearestTriangle(const TriangleMesh& mesh) : impl_(std::make_unique<Impl>()) {
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    Triangle t{static_cast<int>(i), {}, area_normal(mesh, i).normalized()};
    for (int k = 0; k < 3; ++k) t.corner[k] = mesh.vertices[mesh.triangles[i][k]];
    impl_->triangles.push_back(t);
  }
  std::vector<const Triangle*> all;
  for (const Triangle& t : impl_->triangles) all.push_back(&t);
  impl_->tree.init(all.begin(), all.end());
}
NearestTriangle::~NearestTriangle() = default;
NearestTriangle::NearestTriangle(NearestTriangle&&) noexcept = default;
NearestTriangle& NearestTriangle::operator=(NearestTriangle&&) noexcept = default;

int NearestTriangle::nearest(const Vec3& place, const Vec3& out, int guess) const {
  Search search{place, out};
  if (guess >= 0 && guess < static_cast<int>(impl_->triangles.size()))
    search.look_at(impl_->triangles[guess]);
  search.descend(impl_->tree);
  return search.index >= 0 ? search.index : nearest(place);
}

int NearestTriangle::nearest(const Vec3& place) const {
  Search search{place, Vec3::Zero()};
  search.descend(impl_->tree);
  return search.index;
}

}  // namespace firn
