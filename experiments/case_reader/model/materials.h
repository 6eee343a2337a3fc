// [materials.*] and [interactions.*] of a case file.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "experiments/text/toml_document.h"
#include "firn/model.h"

namespace firn {

// Materials in the order of their names.
std::vector<Material> read_materials(const TomlTable& root);

// Reads friction and restitution of a contact without rolling resistance and adhesion.
// `other_keys`: further keys that the caller reads.
Interaction read_dry_interaction(const TomlTable& table, std::vector<std::string_view> other_keys);

struct InteractionTable {
  std::vector<Interaction> laws;  // as Model::interactions
  std::vector<char> given;        // of equal size; 1: the case file has the pair
};
InteractionTable read_interactions(const TomlTable& root, const std::vector<Material>& materials);

// Index of the material that `key` names. Throws for an unknown name.
int material_index(const TomlTable& table, std::string_view key,
                   const std::vector<Material>& materials);

}  // namespace firn
