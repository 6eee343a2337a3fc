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

namespace firn {

// Which file a table of names belongs to.
enum class TomlFormat { other, case_file, measurement, bench_tests, study, suite };

enum class OldNames { warn, accept };  // accept: files that the program wrote earlier

// A key, or with `word` a value of that key, in one kind of table.
struct RenamedKey {
  TomlFormat format;
  std::string_view table;  // path of the table in current names: "stages[].motors[]", "shapes.*"
  std::string_view old_name, name;
};
struct RenamedWord {
  TomlFormat format;
  std::string_view table, key;  // current names
  std::string_view old_word, word;
};
std::span<const RenamedKey> renamed_keys();
std::span<const RenamedWord> renamed_words();

// One use of an old name.
struct OldNameUse {
  std::string path;  // of the key, elements of arrays by their index
  unsigned line = 0;
  std::string old_name, name;
  bool both = false;  // the table has the new name as well
};

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

// Prints "firn: warning: PLACE: ..." on standard error, once for each place and key.
void warn_of_old_name(const std::string& place, const OldNameUse& use);

}  // namespace firn
