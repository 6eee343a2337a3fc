// Names in tables of TOML files: of the table itself, and of others that it refers to.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "experiments/text/toml_document.h"

namespace firn {

// The index of the element whose name a key gives; `what` names the kind of thing ("shape").
int index_of(const TomlTable& table, std::string_view key, const std::string& name,
             const std::vector<std::string_view>& names, std::string_view what);

// A path into a case that a table gives, in current names; warns of an old one.
std::string current_case_key(const TomlTable& table, std::string_view key, const std::string& path);

// A response of a case that a table gives, or an operand with one, in current names; warns of an
// old one.
std::string current_response(const TomlTable& table, std::string_view key, const std::string& text);
// The list of such a key; empty when it is missing.
std::vector<std::string> current_responses(const TomlTable& table, std::string_view key);

// The table `set` of a file about cases: paths in current names and values as TOML text, as
// TomlDocument::apply() takes them. Empty when it is missing.
std::vector<std::pair<std::string, std::string>> read_case_overrides(const TomlTable& table);

// `name` of a table, which becomes a component of a path: not empty, no `.` or `..`, no slash, no
// leading `-`, at most 200 bytes. Throws.
std::string path_name(const TomlTable& table);

// `name` of a table, which becomes part of a path in results files. Throws for one with slashes,
// and for one that an earlier table has.
template <class Named>
std::string fresh_name(const TomlTable& table, const std::vector<Named>& earlier) {
  std::string name = path_name(table);
  for (const Named& other : earlier)
    if (other.name == name)
      table.fail("name", '"' + name + "\" is taken already; expected another name");
  return name;
}

}  // namespace firn
