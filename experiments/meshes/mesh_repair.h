// Repair of defective meshes by admesh (https://github.com/admesh/admesh) in a separate process
// (tools/repair_mesh).
#pragma once

#include <string>

#include "experiments/meshes/length_unit.h"
#include "firn/mesh.h"

namespace firn {

// The result of a repair. Counts are those of its steps, in their order.
struct MeshRepair {
  int degenerate = 0;          // facets without area, removed
  int disconnected_edges = 0;  // edges without a neighboring facet, before the repair
  int joined = 0;              // edges whose corners were within 1e-5 of the diameter
  int removed = 0;             // facets without a neighbor
  int added = 0;               // facets that fill holes
  int reversed = 0;            // facets with the wrong orientation
  int parts = 0;               // connected components
  TriangleMesh mesh;           // repaired, equal corners merged
  bool flat = false;           // the repaired mesh encloses no volume
  MeshDefects left;            // remaining defects of `mesh`

  bool needed() const { return degenerate || disconnected_edges || removed || added || reversed; }
  bool is_repairable() const { return !flat && left.is_valid(); }
  std::string failure_reason() const;  // empty if repairable
  // "drops 1 facet without area, ...; then it is closed", or why it cannot be repaired.
  std::string sentence() const;
};

// Repairs a mesh with finite coordinates and corners that are not merged (read_triangles()). Admesh
// works in single precision. Throws InputError when admesh rejects the mesh.
MeshRepair repair(const TriangleMesh& mesh);

// The end of an error message about the mesh of `file`: the command that may repair it. Empty if no
// defect is an obstacle to `use`; open edges are none to a boundary.
std::string repair_advice(const TriangleMesh& mesh, MeshUse use, const std::string& file,
                          const std::string& length_unit);

// Returns make(), which uses the mesh. Adds the advice to an InputError that it throws.
template <class Make>
auto with_repair_advice(const TriangleMesh& mesh, MeshUse use, const std::string& file,
                        const std::string& length_unit, Make make) {
  try {
    return make();
  } catch (const InputError& error) {
    const std::string advice = repair_advice(mesh, use, file, length_unit);
    if (advice.empty()) throw;
    throw InputError(error.what() + advice);
  }
}

}  // namespace firn
