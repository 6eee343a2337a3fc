// Keys and words of TOML files that have been renamed. Old names are read for one version, with a
// warning. Identities (hashes, keys of stored runs) are formed from the first names, so that a
// rename changes none.
#pragma once

#include <toml++/toml.h>

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/text/alias.h"

namespace firn {

// Which file a table of names belongs to.
enum class TomlFormat { other, case_file, measurement, bench_tests, study, suite };

enum class OldNames { warn, accept };  // accept: files that the program wrote earlier

using TomlAlias = Alias<TomlFormat>;
std::span<const TomlAlias> renamed_keys();
std::span<const TomlAlias> renamed_words();

// Replaces old names by current ones below `root` and reports each use.
void use_current_names(TomlFormat format, toml::table& root,
                       const std::function<void(const OldNameUse&)>& report);
// Replaces current names by the first ones.
void use_first_names(TomlFormat format, toml::table& root);

// The same for the keys of a path into a case; an element of an array takes one key.
void use_current_names(std::vector<std::string>& keys,
                       const std::function<void(const OldNameUse&)>& report);
// A dotted path into a case in current or in first names; unchanged when it has no renamed key.
std::string current_case_path(const std::string& path);
std::string first_case_path(const std::string& path);

}  // namespace firn
