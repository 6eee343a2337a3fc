// Renamed keys and values of results.json files and material records. Files of earlier versions are
// read with the current names.
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string_view>

#include "experiments/text/alias.h"

namespace firn {

// The kinds of documents: "validation", "study" and "material record".
using JsonAlias = Alias<std::string_view>;
std::span<const JsonAlias> renamed_json_keys();
std::span<const JsonAlias> renamed_json_words();

// Replaces old names below `document`. Keeps the order of keys. Leaves an old name where the
// current one is present as well.
void use_current_json_names(nlohmann::ordered_json& document);

// The same for one material record, and the inverse: its hash is computed from the first names.
void use_current_record_names(nlohmann::ordered_json& record);
void use_first_record_names(nlohmann::ordered_json& record);

}  // namespace firn
