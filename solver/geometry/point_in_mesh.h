// Test whether points are inside a closed mesh.
#pragma once

#include <array>
#include <vector>

#include "firn/mesh.h"

namespace firn {

// Counts the intersections of a ray with the mesh. Points on the surface may count as inside or
// outside.
class PointInMesh {
 public:
  explicit PointInMesh(const TriangleMesh& mesh);
  bool contains(const Vec3& point) const;

 private:
  using Triangle = std::array<Vec3, 3>;
  static constexpr int kCells = 48;

  int column(const Vec3& p, int axis) const;

  Mat3 axes_ = Mat3::Zero();  // columns; the ray is along the last one
  Vec3 low_ = Vec3::Zero();
  double cell_ = 1;  // m
  std::vector<Triangle> triangles_;
  std::vector<std::vector<int>> cells_;  // triangles that project to each cell of a square grid
};

}  // namespace firn
