// Mesh files, and the shapes made of those that are small: mass properties, decomposition, parts.
#include <cmath>

#include "experiments/meshes/mesh_file.h"
#include "experiments/meshes/wall_solids.h"
#include "firn/mesh_conflicts.h"
#include "firn/shape.h"
#include "tests/fuzz/fuzz_target.h"

namespace {

using namespace firn;

void require_shape(const Shape& shape) {
  fuzz::require(shape.volume > 0 && std::isfinite(shape.volume), "a shape has a volume");
  fuzz::require(shape.mass > 0 && std::isfinite(shape.mass), "a shape has a mass");
  fuzz::require(shape.inertia.allFinite() && shape.inertia.minCoeff() > 0,
                "a shape has moments of inertia");
  fuzz::require(!shape.parts.empty(), "a shape has parts");
  fuzz::require(std::isfinite(shape.bounding_radius) && shape.bounding_radius > 0,
                "a shape has a bounding radius");
  fuzz::require(std::isfinite(shape.surface_deviation), "a shape says how far its parts deviate");
  for (const ConvexPart& part : shape.parts) {
    fuzz::require(part.vertex_count > 0, "a part has vertices");
    for (int i = 0; i < part.vertex_count; ++i) {
      fuzz::require(part.vertex(i).allFinite(), "a part's vertices are finite");
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::Folder folder;
  const std::string file = folder.put("mesh.stl", fuzz::text_of(data, size));
  TriangleMesh mesh;
  if (!fuzz::accepts([&] { mesh = read_mesh_file(file, 1e-3).mesh; })) return 0;
  for (const Vec3& v : mesh.vertices) fuzz::require(v.allFinite(), "coordinates are finite");
  for (const auto& t : mesh.triangles) {
    for (const int i : t) {
      fuzz::require(i >= 0 && i < static_cast<int>(mesh.vertices.size()), "corners exist");
    }
  }
  const MeshDefects defects = inspect(mesh);
  fuzz::require(defects.is_valid() == defects.to_message().empty(), "defects are named");
  if (mesh.triangles.size() > 200) return 0;
  const MeshConflicts conflicts = find_conflicts(mesh);
  fuzz::require(conflicts.none() == conflicts.to_message().empty(), "conflicts are named");
  for (const MeshConflict& c : conflicts.examples) {
    fuzz::require(c.triangle >= 0 && c.triangle < static_cast<int>(mesh.triangles.size()) &&
                      c.other < static_cast<int>(mesh.triangles.size()),
                  "a conflict names triangles");
    fuzz::require(c.position.allFinite(), "a conflict has a place");
  }
  ShapeOptions options;
  options.name = "mesh";
  options.density = 900;
  options.young_modulus = 1e6;
  options.max_parts = 8;
  fuzz::accepts([&] { wall_solids(mesh, 1e-4); });
  const bool made = fuzz::accepts([&] { require_shape(make_mesh(mesh, options)); });
  fuzz::require(!made || defects.is_valid(), "an unsound mesh makes no shape");
  fuzz::require(!made || conflicts.none(), "a mesh with conflicts makes no shape");
  return 0;
}
