// [shapes.*] of a case file.
#pragma once

#include <string>
#include <vector>

#include "experiments/meshes/mesh_file.h"
#include "experiments/text/toml_document.h"
#include "firn/model.h"

namespace firn {

// Shapes in the order of their names. `directory`: base of the paths of mesh files.
std::vector<Shape> read_shapes(const TomlTable& root, const std::vector<Material>& materials,
                               const std::string& directory);

// Reads the keys of a crescent: variant, chord, thickness, depth, draft, facets, ...
NamedCrescent read_crescent(const TomlTable& table);

// Reads the mesh of the keys `file` and `length_unit`. Writes the absolute path and the hash of the
// content into the table. Throws if the table has another hash, and for a mesh beyond `limits`.
// With the key `any_size`, the limits of size do not apply.
TriangleMesh read_mesh(const TomlTable& table, const std::string& directory,
                       const MeshLimits& limits);

// Index of the shape that `key` names, or of `name`, given by `key`. Throws for an unknown name.
int shape_index(const TomlTable& table, std::string_view key, const std::vector<Shape>& shapes);
int shape_index(const TomlTable& table, std::string_view key, const std::string& name,
                const std::vector<Shape>& shapes);

}  // namespace firn
