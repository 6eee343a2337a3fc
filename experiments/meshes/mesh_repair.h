// What it takes to make a solid of a mesh, by admesh (https://github.com/admesh/admesh) in a
// separate process (tools/repair_mesh).
#pragma once

#include <string>

#include "firn/mesh.h"

namespace firn {

// Counts are of the repair's steps, in this order.
struct MeshRepair {
  int degenerate = 0;          // facets without area, dropped
  int disconnected_edges = 0;  // edges without a neighbour, before the repair
  int joined = 0;              // edges whose corners lay apart by 1e-5 of the diameter
  int removed = 0;             // facets that touched nothing
  int added = 0;               // facets that fill holes
  int reversed = 0;            // facets that faced the wrong way
  int parts = 0;               // pieces that hang together
  TriangleMesh mesh;           // repaired, equal corners merged
  bool flat = false;           // encloses no volume
  MeshDefects left;            // what is still wrong with it

  bool needed() const { return degenerate || disconnected_edges || removed || added || reversed; }
  bool hopeless() const { return flat || !left.sound(); }
  std::string why_hopeless() const;
  // "drops 1 facet without area, ...; then it is closed", or why it is hopeless.
  std::string sentence() const;
};

// The mesh as its file has it, corners not merged; all coordinates finite. Admesh works in single
// precision. Throws InputError when admesh cannot work on the mesh.
MeshRepair repair(const TriangleMesh& mesh);

}  // namespace firn
