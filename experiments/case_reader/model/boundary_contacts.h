// [[boundary_contacts]]: contacts of boundaries with each other.
#pragma once

#include <vector>

#include "experiments/text/toml_document.h"
#include "firn/model.h"

namespace firn {

// The model must have its boundaries, frames and materials.
std::vector<BoundaryContact> read_boundary_contacts(const TomlTable& root, const Model& model);

}  // namespace firn
