// Whether points lie within a closed mesh.
#pragma once

#include <array>
#include <vector>

#include "firn/mesh.h"

namespace firn {

// Counts the crossings of a ray. Points on the surface itself may count as either.
class Interior {
 public:
  explicit Interior(const TriangleMesh& mesh);
  bool contains(const Vec3& point) const;

 private:
  using Triangle = std::array<Vec3, 3>;
  static constexpr int kCells = 48;

  int column(const Vec3& p, int axis) const;

  Mat3 axes_;  // the ray runs along the last of these
  Vec3 low_;
  double cell_ = 1;  // m
  std::vector<Triangle> triangles_;
  std::vector<std::vector<int>> cells_;  // triangles over each cell of a square lattice
};

}  // namespace firn
