#include "experiments/meshes/mesh_union.h"

#include <fmt/format.h>

#include <array>
#include <cstring>
#include <string>

#include "experiments/meshes/mesh_file.h"
#include "experiments/meshes/mesh_program.h"
#include "firn/math.h"
#include "firn/mesh_conflicts.h"

namespace firn {
namespace {

using Corners = std::array<double, 9>;

std::string bytes_of(const TriangleMesh& mesh) {
  std::string bytes;
  bytes.reserve(mesh.triangles.size() * sizeof(Corners));
  for (const auto& triangle : mesh.triangles) {
    for (const int vertex : triangle) {
      const Vec3& corner = mesh.vertices[static_cast<std::size_t>(vertex)];
      bytes.append(reinterpret_cast<const char*>(corner.data()), 3 * sizeof(double));
    }
  }
  return bytes;
}

TriangleMesh mesh_of(const std::string& bytes) {
  TriangleMesh mesh;
  for (std::size_t at = 0; at < bytes.size(); at += sizeof(Corners)) {
    Corners c;
    std::memcpy(c.data(), bytes.data() + at, sizeof(Corners));
    const int first = static_cast<int>(mesh.vertices.size());
    for (std::size_t k = 0; k < 9; k += 3) mesh.vertices.emplace_back(c[k], c[k + 1], c[k + 2]);
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

}  // namespace

TriangleMesh unite(const TriangleMesh& mesh) {
  const std::string bytes = run_mesh_program("firn-unite-mesh", bytes_of(mesh));
  if (bytes.empty() || bytes.size() % sizeof(Corners) != 0)
    throw RunError("firn-unite-mesh: an answer that is not whole");
  TriangleMesh united = merge_equal_corners(mesh_of(bytes));
  const std::string defects = inspect(united).sentence();
  if (!defects.empty()) throw InputError("the union has " + defects);
  const std::string conflicts = find_conflicts(united).sentence();
  if (!conflicts.empty()) throw InputError("the union has " + conflicts);
  return united;
}

}  // namespace firn
