#include "solver/geometry/point_in_mesh.h"

#include <algorithm>
#include <limits>
#include <tuple>

namespace firn {
namespace {

// Whether p lies to the left of an edge; both triangles at the edge get opposite answers.
bool left(const Vec3& a, const Vec3& b, const Vec3& p) {
  const bool swap = std::tie(b.x(), b.y(), b.z()) < std::tie(a.x(), a.y(), a.z());
  const Vec3 &u = swap ? b : a, &v = swap ? a : b;
  const bool above = (v.x() - u.x()) * (p.y() - u.y()) - (v.y() - u.y()) * (p.x() - u.x()) > 0;
  return above != swap;
}

}  // namespace

PointInMesh::PointInMesh(const TriangleMesh& mesh) {
  // Along a direction that no edge of a drawn body is likely to have.
  axes_ = Quat(0.811, 0.273, -0.419, 0.303).normalized().toRotationMatrix();
  low_ = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low_;
  for (const auto& t : mesh.triangles) {
    Triangle triangle;
    for (int k = 0; k < 3; ++k) {
      triangle[k] = axes_ * mesh.vertices[t[k]];
      low_ = low_.cwiseMin(triangle[k]);
      high = high.cwiseMax(triangle[k]);
    }
    triangles_.push_back(triangle);
  }
  cell_ = 1.0001 * (high - low_).head<2>().maxCoeff() / kCells;
  cells_.resize(static_cast<std::size_t>(kCells) * kCells);
  for (std::size_t i = 0; i < triangles_.size(); ++i) {
    const auto& t = triangles_[i];
    const Vec3 least = t[0].cwiseMin(t[1]).cwiseMin(t[2]);
    const Vec3 most = t[0].cwiseMax(t[1]).cwiseMax(t[2]);
    for (int x = column(least, 0); x <= column(most, 0); ++x) {
      for (int y = column(least, 1); y <= column(most, 1); ++y) {
        cells_[x * kCells + y].push_back(static_cast<int>(i));
      }
    }
  }
}

int PointInMesh::column(const Vec3& p, int axis) const {
  return std::clamp(static_cast<int>((p(axis) - low_(axis)) / cell_), 0, kCells - 1);
}

bool PointInMesh::contains(const Vec3& point) const {
  const Vec3 p = axes_ * point;
  bool inside = false;
  for (const int i : cells_[column(p, 0) * kCells + column(p, 1)]) {
    const Triangle& t = triangles_[i];
    const bool a = left(t[0], t[1], p), b = left(t[1], t[2], p), c = left(t[2], t[0], p);
    if (a != b || b != c) continue;
    const Vec3 n = (t[1] - t[0]).cross(t[2] - t[0]);
    if (n.dot(t[0] - p) * n.z() > 0) inside = !inside;
  }
  return inside;
}

}  // namespace firn
