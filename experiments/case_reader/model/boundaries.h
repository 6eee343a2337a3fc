// [[boundaries]] of a case file, and walls of built-in experiments.
#pragma once

#include <string>
#include <vector>

#include "experiments/text/toml_document.h"
#include "firn/model.h"

namespace firn {

// `directory`: base of the paths of mesh files.
std::vector<Boundary> read_boundaries(const TomlTable& root, const std::vector<Material>& materials,
                                      const std::vector<MotionFrame>& frames,
                                      const std::string& directory);

// Pairs of boundaries that may overlap, from the keys `allow_overlap_with`.
std::vector<std::pair<int, int>> read_allowed_overlaps(const TomlTable& root,
                                                       const std::vector<Boundary>& boundaries);

// A half-space behind the plane through `point` (m) with the unit vector `normal` out of the wall.
Boundary plane_boundary(const std::string& name, int material, const Vec3& point,
                        const Vec3& normal);
// A solid box with the edge lengths `size` (m) about `center` (m).
Boundary box_boundary(const std::string& name, int material, const Vec3& size, const Vec3& center);

// Index of the boundary `name`, the value of `key`. Throws for an unknown name.
int boundary_index(const TomlTable& table, std::string_view key, const std::string& name,
                   const std::vector<Boundary>& boundaries);

}  // namespace firn
