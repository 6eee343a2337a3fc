// Which triangle of a mesh lies nearest to a place: where on a surface something happened.
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

  // The number of the triangle nearest to a place (m, axes of the mesh) among those that face
  // `out` (outward normal within 90 degrees); of all where none does. On an edge, always the same
  // one of its neighbours. A good `guess`, as the answer for a place nearby, saves most of the
  // search and changes nothing else; any number will do.
  int nearest(const Vec3& place, const Vec3& out, int guess = -1) const;
  int nearest(const Vec3& place) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace firn
