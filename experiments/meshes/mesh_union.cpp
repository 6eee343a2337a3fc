#include "experiments/meshes/mesh_union.h"

#include <string>

#include "experiments/meshes/mesh_file.h"
#include "experiments/meshes/mesh_program.h"
#include "firn/mesh_conflicts.h"

namespace firn {
TriangleMesh unite(const TriangleMesh& mesh) {
  const std::string facets = run_mesh_program("firn-unite-mesh", facet_bytes<double>(mesh));
  TriangleMesh united = merge_equal_corners(mesh_of_facets<double>(facets));
  const std::string defects = inspect(united).to_message();
  if (!defects.empty()) throw InputError("the union has " + defects);
  const std::string conflicts = find_conflicts(united).to_message();
  if (!conflicts.empty()) throw InputError("the union has " + conflicts);
  return united;
}

}  // namespace firn
