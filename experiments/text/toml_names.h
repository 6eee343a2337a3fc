// Names in tables of TOML files: the name of the table, and references to other tables.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "experiments/text/toml_document.h"

namespace firn {

// The index of `name`, the value of `key`, in `names`. Throws for an unknown name, with a
// suggestion(). `what`: kind of the element in the message ("shape").
int index_of(const TomlTable& table, std::string_view key, const std::string& name,
             const std::vector<std::string_view>& names, std::string_view what);

// The same for elements that have a `name`.
template <class Named>
int index_of(const TomlTable& table, std::string_view key, const std::string& name,
             const std::vector<Named>& all, std::string_view what) {
  std::vector<std::string_view> names;
  names.reserve(all.size());
  for (const Named& one : all) names.emplace_back(one.name);
  return index_of(table, key, name, names, what);
}

// Throws for a document of another kind. Kinds are known by the table that each has alone: case,
// study, suite, sweep or optimization; `table`: that of the expected kind. A measurement is known
// by its `status`.
void require_kind(TomlDocument& document, std::string_view table);
// The same for files that have no such table. `expected`: "a measurement file".
void refuse_other_kinds(TomlDocument& document, std::string_view expected);

// `path`, the value of `key` and a path into a case, with current names. Warns of an old name.
std::string current_case_key(const TomlTable& table, std::string_view key, const std::string& path);

// `text`, the value of `key` and a response or an expression with one, with its current name. Warns
// of an old name.
std::string current_response(const TomlTable& table, std::string_view key, const std::string& text);
// The same for a list of responses; empty when the key is missing.
std::vector<std::string> current_responses(const TomlTable& table, std::string_view key);

// The table `set`: paths into a case with current names, and values as TOML text, in the form that
// TomlDocument::apply() accepts. Empty when it is missing. A table in it with a header or of dotted
// keys continues the path; an inline table is a value. Fills `places` if not null: [overrides]
// where each is stated.
std::vector<std::pair<std::string, std::string>> read_case_overrides(
    const TomlTable& table, std::vector<ValuePlace>* places = nullptr);

// The key `name` of a table, which becomes a component of a path. Throws if it is empty, `.` or
// `..`, has a slash or a leading `-`, or is longer than 200 bytes.
std::string valid_name(const TomlTable& table);

// The path that the key `case` of a table in `file` names, relative to the folder of `file`. Throws
// if there is no such file; `whole`: what `file` is, for the message ("study").
std::string case_path(const TomlTable& table, const std::string& file, std::string_view whole);

// valid_name() of a table. Throws also for a name that an earlier table has.
template <class Named>
std::string unique_table_name(const TomlTable& table, const std::vector<Named>& earlier) {
  std::string name = valid_name(table);
  for (const Named& other : earlier)
    if (other.name == name)
      table.fail("name", '"' + name + "\" is taken already; expected another name");
  return name;
}

}  // namespace firn
