// Finds the triangle of a mesh that is nearest to a point.
#pragma once

#include <memory>

#include "firn/mesh.h"

namespace firn {

class NearestTriangle {
 public:
  // `mesh`: at least one triangle.
  explicit NearestTriangle(const TriangleMesh& mesh);
  ~NearestTriangle();
  NearestTriangle(NearestTriangle&&) noexcept;
  NearestTriangle& operator=(NearestTriangle&&) noexcept;

  // Index of the triangle nearest to `place` (m, mesh axes) among those whose outward normal is
  // within 90 degrees of `out`; among all if there is none. On an edge, the choice between its
  // triangles is deterministic. `guess`: any number; the result for a nearby point saves most of
  // the search. It has no effect on the result.
  int nearest(const Vec3& place, const Vec3& out, int guess = -1) const;
  int nearest(const Vec3& place) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace firn
