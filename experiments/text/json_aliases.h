// Keys and words of results.json files and material records that have been renamed. Files of
// earlier versions are read under the current names.
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string_view>

namespace firn {

// A key of the objects at a path, in documents of a kind: "validation", "study" or "material
// record".
struct RenamedJsonKey {
  std::string_view kind;
  std::string_view path;  // in current names: "comparisons[].value"; empty: the document
  std::string_view old_name, name;
};
// A text that a key of such objects may have.
struct RenamedJsonWord {
  std::string_view kind, path;
  std::string_view key;  // current name
  std::string_view old_word, word;
};
std::span<const RenamedJsonKey> renamed_json_keys();
std::span<const RenamedJsonWord> renamed_json_words();

// Replaces old names below `document`. Keeps the order of keys. Leaves an old name where the
// current one is present as well.
void use_current_json_names(nlohmann::ordered_json& document);

// The same for one material record; its hash is formed from the first names.
void use_current_record_names(nlohmann::json& record);
void use_first_record_names(nlohmann::ordered_json& record);

}  // namespace firn
