// The union of the shells of a mesh, by CGAL (https://www.cgal.org) in a separate process
// (tools/unite_mesh).
#pragma once

#include "firn/mesh.h"

namespace firn {

// mesh: sound (inspect()), m; its shells may overlap, touch, lie inside each other or face inwards.
// Returns a sound mesh without conflicts (find_conflicts()) that bounds what any shell encloses.
// A shell that faces inwards is a cavity of the smallest shell around it, and is reversed where
// none is. Corners are rounded to doubles, and merged as those of a file.
// Throws InputError where there is no such mesh: a shell crosses itself, or the union touches
// itself along an edge.
TriangleMesh unite(const TriangleMesh& mesh);

}  // namespace firn
