// The document that a table belongs to: what it includes, and what overrides put into it.
#include "experiments/text/toml_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <functional>
#include <map>
#include <sstream>

#include "experiments/system/input_file.h"
#include "experiments/system/input_limits.h"
#include "experiments/system/text_encoding.h"
#include "experiments/text/toml_limits.h"
#include "experiments/text/toml_messages.h"

namespace firn {

using namespace toml_text;

namespace {

// Throws InputError PLACE: PATH: ... for the first key or string with a character that is no text.
// Keys, names and titles are one line; other strings may have several.
void check_text(const toml::node& node, const std::string& path, std::string_view key,
                const std::function<void(unsigned, const std::string&)>& refuse_at) {
  const auto refuse = [&](const toml::node& at, const std::string& where, const std::string& what,
                          const std::string& found) {
    refuse_at(line_of(at), fmt::format("{}: {} the character {}; expected printable text",
                                       encode::terminal(where), what, found));
  };
  if (const toml::table* table = node.as_table()) {
    for (const auto& [name, value] : *table) {
      const std::string where = join_path(path, name.str());
      if (const std::string found = encode::first_unprintable(name.str()); !found.empty())
        refuse(value, where, "the key has", found);
      check_text(value, where, name.str(), refuse_at);
    }
  } else if (const toml::array* array = node.as_array()) {
    for (std::size_t i = 0; i < array->size(); ++i)
      check_text((*array)[i], join_path(path, std::to_string(i)), key, refuse_at);
  } else if (const auto* text = node.as_string()) {
    const bool line = key == "name" || key == "title";
    const std::string found =
        line ? encode::first_unprintable(text->get()) : encode::first_control(text->get());
    if (!found.empty()) refuse(node, path, "has", found);
  }
}

toml::table parse(std::string_view text, const std::string& source) {
  require_plain_text(text, source, "a TOML file");
  check_toml_limits(text, source);
  try {
    toml::table table = toml::parse(text, source);
    check_text(table, "", "", [&](unsigned line, const std::string& problem) {
      throw InputError(fmt::format("{}:{}: {}", source, std::max(line, 1u), problem));
    });
    return table;
  } catch (const toml::parse_error& error) {
    throw InputError(fmt::format("{}:{}: TOML: {}; expected valid TOML", source,
                                 error.source().begin.line, error.description()));
  }
}

// The keys of a dotted TOML path: a.b."c d" -> {a, b, c d}. Throws OverrideError with this label.
std::vector<std::string> split_path(const std::string& path, const std::string& label) {
  const auto bad = [&] {
    return OverrideError(label,
                         "not a path; expected keys joined by dots, such as "
                         "interactions.ice-ice.restitution");
  };
  check_toml_limits(path, fmt::format("--set {}", shortened(path)));
  toml::table chain;
  try {
    chain = toml::parse(path + " = 0");
  } catch (const toml::parse_error&) {
    throw bad();
  }
  std::vector<std::string> keys;
  for (const toml::table* t = &chain; t; t = t->begin()->second.as_table()) {
    if (t->size() != 1) throw bad();
    keys.emplace_back(t->begin()->first.str());
  }
  return keys;
}

// A table with the key `v` only, whose value is parsed from the text.
toml::table parse_value(const std::string& text) {
  check_toml_limits(text, "--set");
  try {
    toml::table parsed = toml::parse("v = " + text);
    if (parsed.size() == 1 && parsed.contains("v")) return parsed;
  } catch (const toml::parse_error&) {
    // Not TOML: a bare string such as 0.5 mm.
  }
  toml::table t;
  t.insert("v", text);
  return t;
}

// The element of an array that a path segment means: an index, or the `name` of a table.
toml::node* find_element(toml::array& array, const std::string& segment) {
  std::size_t index = 0;
  const char* last = segment.data() + segment.size();
  const auto [end, error] = std::from_chars(segment.data(), last, index);
  if (error == std::errc() && end == last) return array.get(index);
  for (toml::node& element : array) {
    const toml::table* t = element.as_table();
    if (t && (*t)["name"].value<std::string>() == segment) return &element;
  }
  return nullptr;
}

std::string elements(const toml::array& array) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < array.size(); ++i) {
    const toml::table* t = array.get(i)->as_table();
    const auto name = t ? (*t)["name"].value<std::string>() : std::nullopt;
    names.push_back(name ? fmt::format("{} (\"{}\")", i, *name) : fmt::format("{}", i));
  }
  return comma_list(names);
}

std::optional<std::string> name_of(const toml::node& node) {
  const toml::table* t = node.as_table();
  return t ? (*t)["name"].value<std::string>() : std::nullopt;
}

// The name by which split_path() and find_element() find element `index` again; empty without one.
std::string unique_name(const toml::array& array, std::size_t index) {
  constexpr std::size_t kLongest = 60;  // bytes; longer names hide the message
  const toml::node* element = array.get(index);
  const std::string name = element == nullptr ? "" : name_of(*element).value_or("");
  const bool number = std::ranges::all_of(name, [](char c) { return c >= '0' && c <= '9'; });
  if (number || name.size() > kLongest) return {};
  const auto same =
      std::ranges::count_if(array, [&](const toml::node& other) { return name_of(other) == name; });
  return same == 1 ? name : std::string();
}

// Joins `base` below what `top` says. Nodes are moved: copies would lose their place.
void join(toml::table& top, toml::table&& base) {
  for (auto&& [key, value] : base) {
    toml::node* mine = top.get(key.str());
    if (mine == nullptr) {
      top.insert(key, std::move(value));
    } else if (mine->is_table() && value.is_table()) {
      join(*mine->as_table(), std::move(*value.as_table()));
    } else if (mine->is_array_of_tables() && value.is_array_of_tables()) {
      toml::array joined = std::move(*value.as_array());
      std::map<std::string, std::size_t> by_name;  // the first of each in `base`
      for (std::size_t i = 0; i < joined.size(); ++i)
        if (const auto name = name_of(joined[i])) by_name.emplace(*name, i);
      for (toml::node& element : *mine->as_array()) {
        const auto name = name_of(element);
        const auto same = name ? by_name.find(*name) : by_name.end();
        if (same == by_name.end()) {
          joined.push_back(std::move(*element.as_table()));
          continue;
        }
        toml::table changed = std::move(*element.as_table());
        join(changed, std::move(*joined[same->second].as_table()));
        joined.replace(joined.cbegin() + static_cast<std::ptrdiff_t>(same->second),
                       std::move(changed));
      }
      *mine->as_array() = std::move(joined);
    }
  }
}

// Relative paths under `file` keys, made to start at `directory`.
void lead_files(toml::node& node, const std::filesystem::path& directory) {
  if (toml::array* array = node.as_array()) {
    for (toml::node& element : *array) lead_files(element, directory);
  } else if (toml::table* table = node.as_table()) {
    for (auto&& [key, value] : *table) {
      toml::value<std::string>* text = value.as_string();
      if (key.str() == "file" && text != nullptr)
        *text = (directory / text->get()).lexically_normal().string();
      else
        lead_files(value, directory);
    }
  }
}

// Calls `see` for each node on the way to a canonical path. Returns the last one; null: it is not
// there.
template <class See>
const toml::node* walk(const toml::table& root, const std::string& path, See see) {
  const toml::node* node = &root;
  for (std::size_t from = 0; node != nullptr && from < path.size();) {
    const std::size_t end = std::min(path.find('.', from), path.size());
    const std::string key = path.substr(from, end - from);
    if (const toml::table* table = node->as_table()) {
      node = table->get(key);
    } else if (const toml::array* array = node->as_array()) {
      std::size_t index = array->size();
      std::from_chars(key.data(), key.data() + key.size(), index);
      node = array->get(index);
    } else {
      node = nullptr;
    }
    if (node != nullptr) see(*node);
    from = end + 1;
  }
  return node;
}

std::string with_advice(const std::string& problem, const std::string& advice) {
  return advice.empty() ? problem : problem + "; " + advice;
}

// Whether the node at a path is there and has no place in a file, as what an override made.
bool has_no_line(const toml::table& root, const std::string& path) {
  const toml::node* node = walk(root, path, [](const toml::node&) {});
  return node != nullptr && line_of(*node) == 0;
}

std::string text_of(const toml::table& table) {
  std::ostringstream out;
  out << toml::toml_formatter(table, toml::toml_formatter::default_flags &
                                         ~toml::format_flags::allow_literal_strings)
      << '\n';
  return out.str();
}

std::string read_included(const std::filesystem::path& file, const std::string& by) {
  try {
    return read_input_file(file.string(), "a case file, relative to this one",
                           input_limits::toml_bytes);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: include: {}", by, error.what()));
  }
}

// `by`: FILE:LINE for messages; `depth` ends circles; `files`: how many were included so far.
void include_files(toml::table& table, const std::filesystem::path& directory,
                   const std::string& source, int depth, int& files,
                   const std::function<void(toml::table&, const std::string&)>& use_current) {
  constexpr int kDeepest = 8;
  toml::node* names = table.get("include");
  if (names == nullptr) return;
  const std::string by = fmt::format("{}:{}", source, std::max(line_of(*names), 1u));
  if (depth > kDeepest)
    throw InputError(by + ": include: goes more than 8 files deep; expected no circle");
  toml::array list;
  if (names->is_string())
    list.push_back(*names->value<std::string>());
  else if (names->is_array())
    list = *names->as_array();
  for (const toml::node& one : list) {
    if (!one.is_string()) list.clear();
  }
  if (list.empty())
    throw InputError(
        fmt::format("{}: include: is {}; expected the name of a file, or a list of "
                    "them",
                    by, describe(*names)));
  table.erase("include");
  // In reverse order: later files of the list take precedence.
  for (auto one = list.end(); one-- != list.begin();) {
    if (++files > input_limits::included_files)
      throw InputError(fmt::format("{}: include: makes more than {} files in all; expected fewer",
                                   by, input_limits::included_files));
    const std::filesystem::path name = *one->value<std::string>(), file = directory / name;
    toml::table included = parse(read_included(file, by), file.string());
    use_current(included, file.string());
    include_files(included, file.parent_path(), file.string(), depth + 1, files, use_current);
    lead_files(included, name.parent_path());
    join(table, std::move(included));
  }
}

}  // namespace

OverrideError::OverrideError(std::string by, std::string what_is_wrong, std::string what_to_write)
    : InputError(by + ": " + with_advice(what_is_wrong, what_to_write)),
      label(std::move(by)),
      problem(std::move(what_is_wrong)),
      advice(std::move(what_to_write)) {}

std::string override_label(const std::string& path, const std::string& value) {
  return fmt::format("--set {}={}", path, value);
}

void TomlDocument::include(const std::string& directory) {
  directory_ = directory;
  int files = 0;
  include_files(root_, directory, source_, 1, files,
                [&](toml::table& table, const std::string& file) { use_current(table, file); });
}

std::string TomlDocument::named(const std::string& path) const {
  const toml::node* node = &root_;
  std::string text;
  for (std::size_t from = 0; from < path.size();) {
    const std::size_t end = std::min(path.find('.', from), path.size());
    const std::string key = path.substr(from, end - from);
    const toml::array* array = node == nullptr ? nullptr : node->as_array();
    std::size_t index = 0;
    if (array != nullptr &&
        std::from_chars(key.data(), key.data() + key.size(), index).ec == std::errc()) {
      const std::string name = unique_name(*array, index);
      text = join_path(text, name.empty() ? key : path_key(name));
      node = array->get(index);
    } else {
      text = join_path(text, key);
      const toml::table* table = node == nullptr ? nullptr : node->as_table();
      node = table == nullptr ? nullptr : table->get(key);
    }
    from = end + 1;
  }
  return text;
}

std::string TomlDocument::source_of(const std::string& path) const {
  std::string file = source_;
  walk(root_, path, [&](const toml::node& node) {
    if (node.source().path) file = *node.source().path;
  });
  return file;
}

TomlDocument::TomlDocument(std::string_view text, std::string source, TomlFormat format,
                           OldNames old_names)
    : source_(std::move(source)),
      format_(format),
      old_names_(old_names),
      root_(parse(text, source_)) {
  use_current(root_, source_);
}

namespace {
constexpr const char* kOverride = "--set";
}

void TomlDocument::use_current(toml::table& root, const std::string& file) const {
  use_current_names(format_, root, [&](const OldNameUse& use) {
    const std::string place =
        use.line == 0 || file == kOverride ? file : fmt::format("{}:{}", file, use.line);
    if (use.both)
      throw InputError(
          fmt::format("{}: {}: is the old name of \"{}\", which is given as well; "
                      "expected one of them",
                      place, use.path, use.name));
    if (old_names_ == OldNames::warn) warn_of_old_name(place, use);
  });
}

void TomlDocument::apply(const std::vector<std::pair<std::string, std::string>>& overrides,
                         const std::function<std::string(const std::string&)>& path_in_file) {
  for (const auto& [path, value] : overrides)
    set(path_in_file(path), value, override_label(path, value));
  if (!overrides.empty()) use_current(root_, kOverride);  // words and tables that they brought in
}

bool TomlDocument::has(const std::string& path) const {
  const toml::node* node = &root_;
  for (const std::string& key : split_path(path, path)) {
    const toml::table* table = node->as_table();
    node = table == nullptr ? nullptr : table->get(key);
    if (node == nullptr) return false;
  }
  return true;
}

bool TomlDocument::overridden(const std::string& path) const {
  return std::ranges::any_of(set_by_, [&](const auto& entry) {
    return path == entry.first || path.starts_with(entry.first + ".");
  });
}

std::string TomlDocument::text() const { return text_of(root_); }

std::string TomlDocument::first_names_text() const {
  toml::table copy = root_;
  use_first_names(format_, copy);
  return text_of(copy);
}

void TomlDocument::fail(const std::string& path, unsigned line, const std::string& message,
                        const std::string& advice) const {
  // An override accounts for its own value. Where none does, one accounts for tables that exist
  // only because of it.
  const std::string *own = nullptr, *own_path = nullptr, *made = nullptr;
  const std::string table = path.substr(0, path.rfind('.'));
  for (const auto& [set_path, label] : set_by_) {
    if (path == set_path || path.starts_with(set_path + ".")) {
      own = &label;
      own_path = &set_path;
    }
    const bool made_table =
        (line == 0 && (set_path.starts_with(path + ".") || set_path.starts_with(table + "."))) ||
        (set_path.starts_with(path + ".") && has_no_line(root_, path));
    if (made_table) made = &label;
  }
  const std::string* by = own != nullptr ? own : made;
  const std::string problem = fmt::format("{}: {}", path.empty() ? "case" : named(path), message);
  if (by != nullptr) {
    OverrideError error(*by, problem, advice);
    const bool is_part = own != nullptr && path != *own_path;
    error.of_value = is_part || (own != nullptr && advice.empty());
    if (is_part) error.value_part = path.substr(own_path->size() + 1);
    throw error;
  }
  throw InputError(
      fmt::format("{}:{}: {}", source_of(path), std::max(line, 1u), with_advice(problem, advice)));
}

void TomlDocument::set(const std::string& path, const std::string& value,
                       const std::string& label) {
  std::vector<std::string> segments = split_path(path, label);
  if (format_ == TomlFormat::case_file)
    use_current_names(segments, [&](const OldNameUse& use) {
      if (old_names_ == OldNames::warn) warn_of_old_name(label, use);
    });
  const auto refuse = [&](const std::string& where, const std::string& why,
                          const std::string& advice = "") {
    throw OverrideError(label, fmt::format("{}: {}", named(where), why), advice);
  };
  const auto refuse_text = [&](unsigned, const std::string& problem) {
    OverrideError error(label, problem);
    error.of_value = true;
    throw error;
  };
  toml::node* node = &root_;
  std::string canonical;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const bool last = i + 1 == segments.size();
    const std::string& segment = segments[i];
    if (toml::array* array = node->as_array()) {
      toml::node* element = find_element(*array, segment);
      if (!element) {
        refuse(join_path(canonical, segment), "no such element",
               "expected one of " + elements(*array));
      }
      const auto index = std::find_if(array->begin(), array->end(),
                                      [&](const toml::node& n) { return &n == element; }) -
                         array->begin();
      canonical = join_path(canonical, fmt::format("{}", index));
      if (last) {
        toml::table parsed = parse_value(value);
        check_text(*parsed.get("v"), canonical, "", refuse_text);
        array->replace(array->cbegin() + index, std::move(*parsed.get("v")));
      }
      node = element;
      continue;
    }
    toml::table* table = node->as_table();
    if (!table) refuse(canonical, "is a value; expected a table on the way to the key");
    canonical = join_path(canonical, segment);
    if (last) {
      toml::table parsed = parse_value(value);
      check_text(*parsed.get("v"), canonical, segment, refuse_text);
      table->insert_or_assign(segment, std::move(*parsed.get("v")));
    } else {
      if (!table->contains(segment)) table->insert(segment, toml::table());
      node = table->get(segment);
    }
  }
  set_by_[canonical] = label;
}

}  // namespace firn
