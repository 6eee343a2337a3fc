#include "reports/rendering/simplify_mesh.h"

#include <meshoptimizer.h>

#include <array>
#include <vector>

namespace firn {

TriangleMesh simplified_mesh(const TriangleMesh& mesh, std::size_t wanted) {
  if (mesh.triangles.size() <= wanted) return mesh;
  const Vec3 origin = bounding_box(mesh)[0];
  std::vector<float> positions;  // meshoptimizer takes single precision
  for (const Vec3& v : mesh.vertices)
    for (int k = 0; k < 3; ++k) positions.push_back(static_cast<float>(v[k] - origin[k]));
  std::vector<unsigned> corners;
  for (const auto& t : mesh.triangles)
    for (const int v : t) corners.push_back(static_cast<unsigned>(v));
  constexpr float kAnyError = 1;  // of the extent
  corners.resize(meshopt_simplify(corners.data(), corners.data(), corners.size(), positions.data(),
                                  mesh.vertices.size(), 3 * sizeof(float), 3 * wanted, kAnyError));
  TriangleMesh result;
  std::vector<int> index(mesh.vertices.size(), -1);
  for (std::size_t i = 0; i < corners.size(); i += 3) {
    std::array<int, 3> triangle{};
    for (std::size_t k = 0; k < 3; ++k) {
      int& at = index[corners[i + k]];
      if (at < 0) {
        at = static_cast<int>(result.vertices.size());
        result.vertices.push_back(mesh.vertices[corners[i + k]]);
      }
      triangle[k] = at;
    }
    result.triangles.push_back(triangle);
  }
  return result;
}

}  // namespace firn
