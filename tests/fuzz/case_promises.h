// What an accepted case promises, and the files that cases of the corpus refer to.
#pragma once

#include <string>

#include "experiments/case/case.h"
#include "experiments/case_reader/read_case.h"
#include "experiments/meshes/mesh_file.h"
#include "firn/mesh.h"
#include "tests/fuzz/fuzz_target.h"

namespace firn::fuzz {

// A closed tetrahedron and a single triangle, for meshes named by a case.
class CaseFolder : public Folder {
 public:
  CaseFolder() {
    TriangleMesh mesh;
    mesh.vertices = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)};
    mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    write_stl(path("closed.stl"), mesh, 1);
    mesh.triangles = {{0, 2, 1}};
    write_stl(path("open.stl"), mesh, 1);
    ::setenv("FIRN_MATERIALS", path("none.db").c_str(), 1);  // none but what ships
  }
};

inline void require_round_trip(const Case& c, const CaseFolder& folder) {
  Case again;
  try {
    again = read_case_text(c.resolved, "resolved.toml", folder.path("."));
  } catch (const InputError& error) {
    broken(std::string("a resolved case can be read: ") + error.what() + "\n" + c.resolved);
  }
  if (again.resolved != c.resolved)
    broken("a resolved case resolves to itself:\n" + c.resolved + "\n----\n" + again.resolved);
  require(c.identity == case_identity(c.resolved), "its identity is that of the resolved text");
  require(again.model.timestep == c.model.timestep, "the time step is the same");
  require(again.model.particles.size() == c.model.particles.size(), "so are the particles");
  require(again.model.shapes.size() == c.model.shapes.size(), "so are the shapes");
  for (std::size_t i = 0; i < c.model.shapes.size(); ++i) {
    const Shape &a = c.model.shapes[i], &b = again.model.shapes[i];
    require(a.mass == b.mass && a.inertia == b.inertia && a.stiffness == b.stiffness,
            "so is what a shape weighs");
    require(a.mass > 0 && a.inertia.minCoeff() > 0 && a.inertia.allFinite(),
            "a shape has a mass and moments of inertia");
  }
}

}  // namespace firn::fuzz
