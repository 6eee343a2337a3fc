#include "experiments/text/toml_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "experiments/text/response_aliases.h"
#include "experiments/text/suggestions.h"
#include "experiments/text/toml_messages.h"

namespace firn {

int index_of(const TomlTable& table, std::string_view key, const std::string& name,
             const std::vector<std::string_view>& names, std::string_view what) {
  const auto it = std::ranges::find(names, name);
  if (it != names.end()) return static_cast<int>(it - names.begin());
  if (names.empty()) {
    table.fail(key, fmt::format("unknown {} \"{}\"; the case has none", what, name));
  }
  table.fail(key, fmt::format("unknown {} \"{}\"; {}", what, name, suggestion(name, names)));
}

namespace {

struct FileKind {
  std::string_view table, file, command;
};
constexpr FileKind kFileKinds[] = {{"case", "a case file", "run"},
                                   {"study", "a study file", "calibrate"},
                                   {"suite", "a suite file", "validate"},
                                   {"sweep", "a sweep file", "sweep"},
                                   {"optimization", "an optimization file", "optimize"}};

}  // namespace

void refuse_other_kinds(TomlDocument& document, std::string_view expected) {
  for (const FileKind& kind : kFileKinds) {
    const toml::node* node = document.root().get(kind.table);
    if (node == nullptr || !node->is_table()) continue;
    document.fail(std::string(kind.table), toml_text::line_of(*node),
                  fmt::format("is a file for firn {}; expected {}", kind.command, expected));
  }
}

void require_kind(TomlDocument& document, std::string_view table) {
  if (document.root().contains(table)) return;
  const FileKind& wanted = *std::ranges::find(kFileKinds, table, &FileKind::table);
  const std::string expected = fmt::format("{} (firn {})", wanted.file, wanted.command);
  refuse_other_kinds(document, expected);
  const toml::node* status = document.root().get("status");
  if (status != nullptr && status->is_string() && document.root().contains("response"))
    document.fail("status", toml_text::line_of(*status),
                  fmt::format("is a key of a measurement file; expected {}", expected));
}

namespace {

// Warns of an old name in the value of `key`: at the entry of a list that is `text`.
void warn_of_old_text(const TomlTable& table, std::string_view key, const std::string& text,
                      const std::string& current) {
  std::string place = table.place(key);
  if (table.is_list(key)) {
    const std::vector<std::string> texts = table.strings(key);
    const auto entry = std::ranges::find(texts, text);
    if (entry != texts.end())
      place = table.element_places(key).at(static_cast<std::size_t>(entry - texts.begin())).whole;
  }
  warn_of_old_name(place, {"", 0, text, current, false});
}

}  // namespace

std::string current_case_key(const TomlTable& table, std::string_view key,
                             const std::string& path) {
  const std::string current = current_case_path(path);
  if (current != path) warn_of_old_text(table, key, path, current);
  return current;
}

std::string current_response(const TomlTable& table, std::string_view key,
                             const std::string& text) {
  const std::string current = current_response_name(text);
  if (current != text) warn_of_old_text(table, key, text, current);
  return current;
}

std::vector<std::string> current_responses(const TomlTable& table, std::string_view key) {
  std::vector<std::string> texts = table.strings(key);
  for (std::string& text : texts) text = current_response(table, key, text);
  return texts;
}

namespace {

// Calls see(values, key, path) for each value below a table `set`. `above`: path of `values`.
template <class See>
void visit_overrides(const TomlTable& values, const std::string& above, const See& see) {
  for (const std::string& key : values.keys()) {
    // Keys of `set` itself are paths.
    const std::string path = above.empty() ? key : above + "." + toml_text::path_key(key);
    if (values.is_block_table(key))
      visit_overrides(values.required_table(key), path, see);
    else
      see(values, key, path);
  }
}

}  // namespace

std::vector<std::pair<std::string, std::string>> read_case_overrides(
    const TomlTable& table, std::vector<ValuePlace>* places) {
  std::vector<std::pair<std::string, std::string>> set;
  if (!table.has("set")) return set;
  const std::string name = table.document().named(toml_text::join_path(table.path(), "set"));
  visit_overrides(table.required_table("set"), "",
                  [&](const TomlTable& values, const std::string& key, const std::string& path) {
                    const ValuePlace place = values.value_place(key, name);
                    const std::string current = current_case_path(path);
                    if (current != path)
                      warn_of_old_name(place.whole, {"", 0, path, current, false});
                    set.emplace_back(current, values.value_text(key));
                    if (places != nullptr) places->push_back(place);
                  });
  return set;
}

std::string valid_name(const TomlTable& table) {
  constexpr std::size_t kLongest = 200;  // bytes; file systems allow 255
  const std::string name = table.string("name");
  if (name.size() > kLongest)
    table.fail("name",
               fmt::format("has {} bytes; expected a name of at most {}", name.size(), kLongest));
  if (name.find('/') != std::string::npos)
    table.fail("name", fmt::format("is \"{}\"; expected a name without slashes", name));
  if (name.empty() || name == "." || name == ".." || name[0] == '-')
    table.fail("name", fmt::format("is \"{}\"; expected a name that can be a folder's: not empty, "
                                   "not \".\" or \"..\", no \"-\" at its start",
                                   name));
  return name;
}

std::string case_path(const TomlTable& table, const std::string& file, std::string_view whole) {
  const auto found = std::filesystem::path(file).parent_path() / table.string("case");
  std::error_code unreadable;  // as a name that is too long
  const bool exists = std::filesystem::exists(found, unreadable);
  if (!exists || std::filesystem::is_directory(found, unreadable))
    table.fail("case",
               fmt::format("{} {}; expected a case file, relative to the {}", found.string(),
                           exists ? "is a folder" : "does not exist", whole));
  return found.lexically_normal().string();
}

}  // namespace firn
