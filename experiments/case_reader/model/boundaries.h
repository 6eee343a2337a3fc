// [[boundaries]] of a case file, and the walls that experiments build.
#pragma once

#include <string>
#include <vector>

#include "experiments/text/toml_document.h"
#include "firn/model.h"

namespace firn {

std::vector<Boundary> read_boundaries(const TomlTable& root, const std::vector<Material>& materials,
                                      const std::vector<MotionFrame>& frames,
                                      const std::string& directory);

// `may_touch` of all boundaries: pairs that may overlap.
std::vector<std::pair<int, int>> read_may_touch(const TomlTable& root,
                                                const std::vector<Boundary>& boundaries);

// The half-space behind the plane through `point` (m) with unit `normal` out of the wall.
Boundary plane_boundary(const std::string& name, int material, const Vec3& point,
                        const Vec3& normal);
// A solid box about its origin, edges `size` (m).
Boundary box_boundary(const std::string& name, int material, const Vec3& size, const Vec3& center);

// The index of the boundary of that name, given under `key`. Throws for an unknown one.
int boundary_index(const TomlTable& table, std::string_view key, const std::string& name,
                   const std::vector<Boundary>& boundaries);

}  // namespace firn
