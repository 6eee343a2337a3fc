// Finds the triangle of a mesh that is nearest to a point.
#pragma once

#include <memory>

#include "firn/mesh.h"

namespace firn {

class NearestTriangle {
 public:
  // Of a mesh with at least one triangle.
  explicit NearestTriangle(const TriangleMesh& mesh);
  ~NearestTriangle();
  NearestTriangle(NearestTriangle&&) noexcept;
  NearestTriangle& operator=(NearestTriangle&&) noexcept;

  // The number of the triangle nearest to a place (m, axes of the mesh) among those that face `out`
  // (outward normal within 90 degrees); of all where none does. On an edge, always the same one of
  // its neighbours. `guess` may be any number. A good guess, such as the result for a nearby point,
  // saves most of the search and does not change the result.
  int nearest(const Vec3& place, const Vec3& out, int guess = -1) const;
  int nearest(const Vec3& place) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace firn
