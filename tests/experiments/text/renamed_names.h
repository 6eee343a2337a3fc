// Renames the keys of TOML tables, for tests of old names.
#pragma once

#include <sstream>
#include <string>
#include <vector>

#include "experiments/text/toml_document.h"

namespace firn::test {

inline std::string toml_text(const toml::table& table) {
  std::ostringstream out;
  out << table;
  return out.str();
}

inline std::vector<OldNameUse> current_names(TomlFormat format, toml::table& root) {
  std::vector<OldNameUse> uses;
  use_current_names(format, root, [&](const OldNameUse& use) { uses.push_back(use); });
  return uses;
}

}  // namespace firn::test
