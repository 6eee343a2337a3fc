// [shapes.*] of a case file.
#pragma once

#include <string>
#include <vector>

#include "experiments/meshes/mesh_file.h"
#include "experiments/text/toml_document.h"
#include "firn/model.h"

namespace firn {

// In the order of their names. Mesh files lie relative to `directory`.
std::vector<Shape> read_shapes(const TomlTable& root, const std::vector<Material>& materials,
                               const std::string& directory);

// The keys variant, chord, thickness, depth, tip, dish, draft and facets of a crescent.
NamedCrescent read_crescent(const TomlTable& table);

// The mesh named by the keys `file` and `length_unit`. Writes the absolute path and the hash of
// the content back into the table; throws when a hash stands there already and differs,
// and for a mesh beyond `limits`. The key `any_size` leaves only their number of triangles.
TriangleMesh read_mesh(const TomlTable& table, const std::string& directory,
                       const MeshLimits& limits);

// The index of a shape named by a key. Throws for an unknown one.
int shape_index(const TomlTable& table, std::string_view key, const std::vector<Shape>& shapes);

}  // namespace firn
