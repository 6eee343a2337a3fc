// Conflicts of a closed mesh: intersecting surfaces and nested shells.
#pragma once

#include <string>
#include <vector>

#include "firn/mesh.h"

namespace firn {

// A shell is a set of triangles that are connected by their edges.
struct MeshConflict {
  enum class Kind {
    crossing,     // two triangles of one shell intersect
    overlapping,  // triangles of two shells intersect
    nested,       // a shell that faces outwards inside another one
    inverted,     // a shell that faces inwards and is not a cavity of another one
  };
  Kind kind;
  // Numbers of the triangles, from 0; of a nested or inverted shell, its first triangle, and the
  // first one of a shell around it or -1.
  int triangle = -1, other = -1;
  Vec3 position = Vec3::Zero();  // m, mesh axes: common point, or center of the first triangle
};

struct MeshConflicts {
  int intersections = 0;       // pairs of triangles of one shell
  int overlapping_shells = 0;  // pairs of shells
  int nested_shells = 0;
  int inverted_shells = 0;
  std::vector<MeshConflict> examples;  // at most one of each kind

  bool none() const { return examples.empty(); }
  // Lists and counts the conflicts, with triangle numbers from 1 and a position in mm. Empty
  // without conflicts.
  std::string to_message() const;
};

// A shell that faces inwards inside another one is a cavity and not a conflict, nor is a solid
// inside the cavity. Surfaces that touch, or overlap by less than a millionth of the diagonal of
// the bounding box, are not in conflict. The search stops at 1000 pairs and at 100 nested or
// inverted shells. Open meshes are searched for intersecting triangles only.
MeshConflicts find_conflicts(const TriangleMesh& mesh);

}  // namespace firn
