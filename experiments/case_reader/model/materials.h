// [materials.*] and [interactions.*] of a case file.
#pragma once

#include <string>
#include <vector>

#include "experiments/text/toml_document.h"
#include "firn/model.h"

namespace firn {

// In the order of their names.
std::vector<Material> read_materials(const TomlTable& root);

struct InteractionTable {
  std::vector<Interaction> laws;  // as Model::interactions
  std::vector<char> given;        // the same shape: 1 where the case file has the pair
};
InteractionTable read_interactions(const TomlTable& root, const std::vector<Material>& materials);

// The index of a material named by a key. Throws for an unknown one.
int material_index(const TomlTable& table, std::string_view key,
                   const std::vector<Material>& materials);

}  // namespace firn
