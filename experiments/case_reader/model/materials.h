// [materials.*] and [interactions.*] of a case file.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "experiments/text/toml_document.h"
#include "firn/model.h"

namespace firn {

// In the order of their names.
std::vector<Material> read_materials(const TomlTable& root);

// Friction and restitution of a contact that neither rolls with resistance nor adheres. The table
// may have `other_keys`, too.
Interaction read_dry_interaction(const TomlTable& table, std::vector<std::string_view> other_keys);

struct InteractionTable {
  std::vector<Interaction> laws;  // as Model::interactions
  std::vector<char> given;        // the same shape: 1 where the case file has the pair
};
InteractionTable read_interactions(const TomlTable& root, const std::vector<Material>& materials);

// The index of a material named by a key. Throws for an unknown one.
int material_index(const TomlTable& table, std::string_view key,
                   const std::vector<Material>& materials);

}  // namespace firn
