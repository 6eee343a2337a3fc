// Renamed keys and values of TOML files. Old names are accepted for one version, with a warning.
// Hashes and keys of stored runs are computed from the first names, so that a rename does not
// change them.
#pragma once

#include <toml++/toml.h>

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/text/alias.h"

namespace firn {

// The kind of a TOML file.
enum class TomlFormat { other, case_file, measurement, bench_tests, study, suite };

enum class OldNames { warn, accept };  // accept: without warning, for files that the program wrote

using TomlAlias = Alias<TomlFormat>;
std::span<const TomlAlias> renamed_keys();
std::span<const TomlAlias> renamed_words();

// Replaces old names by current ones below `root` and reports each use.
void use_current_names(TomlFormat format, toml::table& root,
                       const std::function<void(const OldNameUse&)>& report);
// Replaces current names by the first ones.
void use_first_names(TomlFormat format, toml::table& root);

// The same for the keys of a path into a case. The index or name of an array element is one key.
void use_current_names(std::vector<std::string>& keys,
                       const std::function<void(const OldNameUse&)>& report);
// A dotted path into a case with current or with first names. Unchanged without a renamed key.
std::string current_case_path(const std::string& path);
std::string first_case_path(const std::string& path);

}  // namespace firn
