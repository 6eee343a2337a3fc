// The union of the shells of a mesh, by CGAL (https://www.cgal.org) in a separate process
// (tools/unite_mesh).
#pragma once

#include "firn/mesh.h"

namespace firn {

// Union of the volumes of all shells of a mesh (m). The mesh must be watertight (inspect()); its
// shells may overlap, touch, contain each other or face inwards. A shell that faces inwards is a
// cavity of the smallest shell around it; without such a shell it is reversed. Returns a watertight
// mesh without conflicts (find_conflicts()), with corners rounded to doubles and merged. Throws
// InputError if there is no such mesh: a shell intersects itself, or the union touches itself along
// an edge.
TriangleMesh unite(const TriangleMesh& mesh);

}  // namespace firn
