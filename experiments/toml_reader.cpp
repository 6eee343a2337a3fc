#include "experiments/toml_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

namespace firn {
namespace {

std::string join_path(std::string_view path, std::string_view key) {
  if (path.empty()) return std::string(key);
  if (key.empty()) return std::string(path);
  return fmt::format("{}.{}", path, key);
}

unsigned line_of(const toml::node& node) { return node.source().begin.line; }

// How messages call a value of the wrong type.
std::string describe(const toml::node& node) {
  if (const auto s = node.value_exact<std::string>()) return fmt::format("\"{}\"", *s);
  if (const auto i = node.value_exact<std::int64_t>()) return fmt::format("the bare number {}", *i);
  if (const auto d = node.value_exact<double>()) return fmt::format("the bare number {}", *d);
  if (const auto b = node.value_exact<bool>()) return *b ? "true" : "false";
  if (node.is_array_of_tables()) return "an array of tables";
  if (node.is_array()) return "an array";
  if (node.is_table()) return "a table";
  return "a date or time";
}

toml::table parse(std::string_view text, const std::string& source) {
  try {
    return toml::parse(text, source);
  } catch (const toml::parse_error& error) {
    throw InputError(fmt::format("{}:{}: TOML: {}; expected valid TOML", source,
                                 error.source().begin.line, error.description()));
  }
}

// The keys of a dotted TOML path: a.b."c d" -> {a, b, c d}.
std::vector<std::string> split_path(const std::string& path) {
  const auto bad = [&] {
    return InputError(
        fmt::format("--set {}: not a path; expected keys joined by dots, such as "
                    "interactions.ice-ice.restitution",
                    path));
  };
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

// A table of the one key `v`, whose value is what the text says.
toml::table parse_value(const std::string& text) {
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
      for (toml::node& element : *mine->as_array()) {
        const auto same = std::ranges::find_if(joined, [&](const toml::node& n) {
          return name_of(n) && name_of(n) == name_of(element);
        });
        if (same == joined.end()) {
          joined.push_back(std::move(*element.as_table()));
          continue;
        }
        toml::table changed = std::move(*element.as_table());
        join(changed, std::move(*(*same).as_table()));
        joined.replace(joined.cbegin() + (same - joined.begin()), std::move(changed));
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

std::string read_included(const std::filesystem::path& file, const std::string& by) {
  std::ifstream in(file, std::ios::binary);
  if (!in.is_open() || std::filesystem::is_directory(file)) {
    throw InputError(
        fmt::format("{}: include: \"{}\" cannot be opened; expected a case file, "
                    "relative to this one",
                    by, file.string()));
  }
  return {std::istreambuf_iterator<char>(in), {}};
}

// `by`: FILE:LINE for messages; `depth` ends circles.
void include_files(toml::table& table, const std::filesystem::path& directory,
                   const std::string& source, int depth) {
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
  // The last one goes before the others, as what is nearer to the file that asks.
  for (auto one = list.end(); one-- != list.begin();) {
    const std::filesystem::path name = *one->value<std::string>(), file = directory / name;
    toml::table included = parse(read_included(file, by), file.string());
    include_files(included, file.parent_path(), file.string(), depth + 1);
    lead_files(included, name.parent_path());
    join(table, std::move(included));
  }
}

}  // namespace

void TomlDocument::include(const std::string& directory) {
  directory_ = directory;
  include_files(root_, directory, source_, 1);
}

std::string TomlDocument::source_of(const std::string& path) const {
  const toml::node* node = &root_;
  std::string file = source_;
  for (std::size_t from = 0; node != nullptr && from <= path.size();) {
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
    if (node != nullptr && node->source().path) file = *node->source().path;
    from = end + 1;
  }
  return file;
}

TomlDocument::TomlDocument(std::string_view text, std::string source)
    : source_(std::move(source)), root_(parse(text, source_)) {}

void TomlDocument::apply(const std::vector<std::pair<std::string, std::string>>& overrides) {
  for (const auto& [path, value] : overrides)
    set(path, value, fmt::format("--set {}={}", path, value));
}

bool TomlDocument::has(const std::string& path) const {
  const toml::node* node = &root_;
  for (const std::string& key : split_path(path)) {
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

std::string TomlDocument::text() const {
  std::ostringstream out;
  out << toml::toml_formatter(root_, toml::toml_formatter::default_flags &
                                         ~toml::format_flags::allow_literal_strings)
      << '\n';
  return out.str();
}

void TomlDocument::fail(const std::string& path, unsigned line, const std::string& message) const {
  std::string place = fmt::format("{}:{}", source_of(path), std::max(line, 1u));
  // An override accounts for its own value, and for tables that exist only because of it.
  const std::string table = path.substr(0, path.rfind('.'));
  for (const auto& [set_path, label] : set_by_) {
    const bool made =
        line == 0 && (set_path.starts_with(path + ".") || set_path.starts_with(table + "."));
    if (made || path == set_path || path.starts_with(set_path + ".")) place = label;
  }
  throw InputError(fmt::format("{}: {}: {}", place, path.empty() ? "case" : path, message));
}

void TomlDocument::set(const std::string& path, const std::string& value,
                       const std::string& label) {
  const std::vector<std::string> segments = split_path(path);
  const auto refuse = [&](const std::string& where, const std::string& why) {
    throw InputError(fmt::format("{}: {}: {}", label, where, why));
  };
  toml::node* node = &root_;
  std::string canonical;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const bool last = i + 1 == segments.size();
    const std::string& segment = segments[i];
    if (toml::array* array = node->as_array()) {
      toml::node* element = find_element(*array, segment);
      if (!element) {
        refuse(join_path(canonical, segment),
               fmt::format("no such element; expected one of {}", elements(*array)));
      }
      const auto index = std::find_if(array->begin(), array->end(),
                                      [&](const toml::node& n) { return &n == element; }) -
                         array->begin();
      canonical = join_path(canonical, fmt::format("{}", index));
      if (last) {
        toml::table parsed = parse_value(value);
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
      table->insert_or_assign(segment, std::move(*parsed.get("v")));
    } else {
      if (!table->contains(segment)) table->insert(segment, toml::table());
      node = table->get(segment);
    }
  }
  set_by_[canonical] = label;
}

TomlTable::TomlTable(TomlDocument& document, toml::table& table, std::string path, unsigned line)
    : document_(&document), table_(&table), path_(std::move(path)), line_(line) {}

TomlTable TomlTable::root(TomlDocument& document) {
  return TomlTable(document, document.root(), "", 1);
}

void TomlTable::allow(std::span<const std::string_view> keys) const {
  for (const auto& [key, value] : *table_) {
    if (std::ranges::find(keys, key.str()) != keys.end()) continue;
    document_->fail(path_of(key.str()), key.source().begin.line,
                    fmt::format("unknown key; the nearest known one is \"{}\"",
                                nearest(key.str(), {keys.begin(), keys.end()})));
  }
}

void TomlTable::allow(std::initializer_list<std::string_view> keys) const {
  allow(std::span(keys.begin(), keys.size()));
}

bool TomlTable::has(std::string_view key) const { return table_->contains(key); }

bool TomlTable::is_list(std::string_view key) const {
  const toml::node* node = table_->get(key);
  return node != nullptr && node->is_array();
}

std::vector<std::string> TomlTable::keys() const {
  std::vector<std::string> names;
  for (const auto& [key, value] : *table_) names.emplace_back(key.str());
  return names;
}

std::string TomlTable::path_of(std::string_view key) const { return join_path(path_, key); }

void TomlTable::fail(std::string_view key, const std::string& message) const {
  unsigned line = line_;
  if (const toml::node* node = key.empty() ? nullptr : table_->get(key)) {
    if (line_of(*node) > 0) line = line_of(*node);
  }
  document_->fail(path_of(key), line, message);
}

std::string TomlTable::place() const {
  return fmt::format("{}:{}: {}", document_->source_of(path_), std::max(line_, 1u), path_);
}

const toml::node& TomlTable::require(std::string_view key) const {
  const toml::node* node = table_->get(key);
  if (!node) fail(key, "missing; expected this key");
  return *node;
}

const std::string& TomlTable::text(std::string_view key, const std::string& wanted) const {
  const toml::node* node = table_->get(key);
  if (!node) fail(key, fmt::format("missing; expected {}", wanted));
  const auto* s = node->as_string();
  if (!s) fail(key, fmt::format("is {}; expected {}", describe(*node), wanted));
  return s->get();
}

std::string TomlTable::string(std::string_view key) const { return text(key, "a string"); }

std::string TomlTable::string(std::string_view key, const std::string& fallback) const {
  if (!has(key)) set(key, fallback);
  return string(key);
}

std::string TomlTable::value_text(std::string_view key) const {
  std::ostringstream out;
  require(key).visit([&](const auto& value) { out << value; });
  return out.str();
}

std::vector<std::string> TomlTable::value_texts(std::string_view key) const {
  std::vector<std::string> texts;
  if (!has(key)) return texts;
  const toml::node& node = require(key);
  const toml::array* array = node.as_array();
  if (array == nullptr) fail(key, fmt::format("is {}; expected a list of values", describe(node)));
  for (const toml::node& element : *array) {
    std::ostringstream out;
    element.visit([&](const auto& value) { out << value; });
    texts.push_back(out.str());
  }
  return texts;
}

bool TomlTable::boolean(std::string_view key, bool fallback) const {
  if (!has(key)) set(key, fallback);
  const toml::node& node = require(key);
  if (const auto b = node.value_exact<bool>()) return *b;
  fail(key, fmt::format("is {}; expected true or false", describe(node)));
}

std::int64_t TomlTable::integer64(std::string_view key, std::int64_t least,
                                  std::int64_t most) const {
  const std::string wanted = fmt::format("a whole number of at least {}", least);
  const toml::node* node = table_->get(key);
  if (!node) fail(key, fmt::format("missing; expected {}", wanted));
  const auto i = node->value_exact<std::int64_t>();
  if (!i || *i < least) fail(key, fmt::format("is {}; expected {}", describe(*node), wanted));
  if (*i > most) fail(key, fmt::format("is {}; expected at most {}", describe(*node), most));
  return *i;
}

int TomlTable::integer(std::string_view key, int least) const {
  return static_cast<int>(integer64(key, least, std::numeric_limits<int>::max()));
}

int TomlTable::integer(std::string_view key, int least, int fallback) const {
  if (!has(key)) set(key, fallback);
  return integer(key, least);
}

double TomlTable::number(std::string_view key) const {
  const toml::node* node = table_->get(key);
  if (!node) fail(key, "missing; expected a number");
  if (!node->is_number()) fail(key, fmt::format("is {}; expected a number", describe(*node)));
  const double d = *node->value<double>();
  if (!std::isfinite(d)) fail(key, fmt::format("is {}; expected a finite number", d));
  return d;
}

double TomlTable::number(std::string_view key, double fallback) const {
  if (!has(key)) set(key, fallback);
  return number(key);
}

std::string TomlTable::choice(std::string_view key, std::span<const std::string_view> words,
                              std::string_view fallback) const {
  const std::string wanted = "one of " + comma_list(words);
  if (!has(key) && !fallback.empty()) set(key, std::string(fallback));
  const std::string word = text(key, wanted);
  if (std::ranges::find(words, word) == words.end()) {
    fail(key, fmt::format("is \"{}\"; expected {}", word, wanted));
  }
  return word;
}

std::string TomlTable::choice(std::string_view key, std::initializer_list<std::string_view> words,
                              std::string_view fallback) const {
  return choice(key, std::span(words.begin(), words.size()), fallback);
}

void TomlTable::check_sign(std::string_view key, double value, const Dimension& dimension,
                           Sign sign) const {
  if (sign == Sign::any || value > 0 || (sign == Sign::non_negative && value == 0)) return;
  fail(key,
       fmt::format("is {}; expected {} {} zero", describe(*table_->get(key)),
                   dimension_name(dimension), sign == Sign::positive ? "above" : "of at least"));
}

double TomlTable::quantity(std::string_view key, const Dimension& dimension, Sign sign,
                           std::string_view fallback) const {
  if (!has(key) && !fallback.empty()) set(key, std::string(fallback));
  const std::string& value_text = text(key, example(dimension));
  const double value = at(key, [&] { return parse_quantity(value_text, dimension); });
  check_sign(key, value, dimension, sign);
  return value;
}

std::vector<double> TomlTable::quantities(std::string_view key, const Dimension& dimension) const {
  std::vector<double> values;
  for (const std::string& one : strings(key))
    values.push_back(at(key, [&] { return parse_quantity(one, dimension); }));
  if (values.empty())
    fail(key, fmt::format("is missing; expected a list of {}", example(dimension)));
  return values;
}
std::optional<double> TomlTable::optional_quantity(std::string_view key, const Dimension& dimension,
                                                   Sign sign) const {
  if (!has(key)) return std::nullopt;
  return quantity(key, dimension, sign);
}

Vec3 TomlTable::vector(std::string_view key, const Dimension& dimension,
                       std::string_view fallback) const {
  if (!has(key) && !fallback.empty()) set(key, std::string(fallback));
  const std::string& value_text = text(key, example(dimension, 3));
  return at(key, [&] { return parse_vector(value_text, dimension); });
}

Vec3 TomlTable::sizes(std::string_view key) const {
  const Vec3 v = vector(key, dimension::length);
  if (v.minCoeff() <= 0) {
    fail(key, fmt::format("is {}; expected three lengths above zero", describe(*table_->get(key))));
  }
  return v;
}

std::vector<double> TomlTable::numbers(std::string_view key, std::size_t count,
                                       const char* wanted) const {
  const toml::node* node = table_->get(key);
  if (!node) fail(key, fmt::format("missing; expected {}", wanted));
  const toml::array* array = node->as_array();
  if (!array) fail(key, fmt::format("is {}; expected {}", describe(*node), wanted));
  std::vector<double> values;
  for (const toml::node& element : *array) {
    const auto d = element.is_number() ? element.value<double>() : std::nullopt;
    if (!d || !std::isfinite(*d)) {
      fail(key, fmt::format("holds {}; expected {}", describe(element), wanted));
    }
    values.push_back(*d);
  }
  if (values.size() != count) {
    fail(key, fmt::format("has {} entries; expected {}", values.size(), wanted));
  }
  return values;
}

std::vector<int> TomlTable::integers(std::string_view key) const {
  if (!has(key)) return {};
  const toml::node& node = require(key);
  const toml::array* array = node.as_array();
  constexpr const char* kWanted = "a list of whole numbers, such as [1, 2]";
  if (!array) fail(key, fmt::format("is {}; expected {}", describe(node), kWanted));
  std::vector<int> values;
  for (const toml::node& element : *array) {
    const auto i = element.value_exact<std::int64_t>();
    if (!i || *i != static_cast<int>(*i))
      fail(key, fmt::format("holds {}; expected {}", describe(element), kWanted));
    values.push_back(static_cast<int>(*i));
  }
  return values;
}

std::array<int, 3> TomlTable::counts(std::string_view key) const {
  constexpr const char* kWanted = "three whole numbers of at least 1, [nx, ny, nz]";
  const auto n = numbers(key, 3, kWanted);
  std::array<int, 3> counts{};
  for (std::size_t i = 0; i < 3; ++i) {
    if (!(n[i] >= 1 && n[i] <= std::numeric_limits<int>::max()) || n[i] != std::floor(n[i])) {
      fail(key, fmt::format("holds {}; expected {}", n[i], kWanted));
    }
    counts[i] = static_cast<int>(n[i]);
  }
  return counts;
}

std::vector<std::array<int, 2>> TomlTable::integer_pairs(std::string_view key) const {
  constexpr const char* kWanted = "pairs of whole numbers, [[0, 1], [1, 2]]";
  const toml::array* list = require(key).as_array();
  if (!list) fail(key, fmt::format("is {}; expected {}", describe(require(key)), kWanted));
  std::vector<std::array<int, 2>> pairs;
  for (const toml::node& element : *list) {
    const toml::array* pair = element.as_array();
    if (!pair || pair->size() != 2)
      fail(key, fmt::format("holds {}; expected {}", describe(element), kWanted));
    std::array<int, 2>& out = pairs.emplace_back();
    for (std::size_t k = 0; k < 2; ++k) {
      const auto n = (*pair)[k].value_exact<std::int64_t>();
      if (!n || *n < 0 || *n > std::numeric_limits<int>::max())
        fail(key, fmt::format("holds {}; expected {}", describe((*pair)[k]), kWanted));
      out[k] = static_cast<int>(*n);
    }
  }
  return pairs;
}

Vec3 TomlTable::direction(std::string_view key) const {
  const auto n = numbers(key, 3, "a direction [x, y, z]");
  const Vec3 v(n[0], n[1], n[2]);
  const double length = v.norm();
  if (!(length > 1e-12) || !std::isfinite(length)) {
    fail(key,
         fmt::format("has length {}; expected a direction [x, y, z] that is not zero", length));
  }
  return v / length;
}

Quat TomlTable::orientation(std::string_view key) const {
  constexpr double kTolerance = 1e-6;
  if (!has(key)) set(key, toml::array{1, 0, 0, 0});
  const auto n = numbers(key, 4, "a unit quaternion [w, x, y, z]");
  const Quat q(n[0], n[1], n[2], n[3]);
  const double norm = q.norm();
  if (!(std::abs(norm - 1) <= kTolerance)) {
    fail(key, fmt::format("has norm {:.7g}; expected a unit quaternion [w, x, y, z]", norm));
  }
  return q.normalized();
}

std::vector<std::string> TomlTable::strings(std::string_view key) const {
  if (!has(key)) return {};
  const toml::node& node = require(key);
  const toml::array* array = node.as_array();
  if (!array) fail(key, fmt::format("is {}; expected an array of strings", describe(node)));
  std::vector<std::string> values;
  for (const toml::node& element : *array) {
    const auto* s = element.as_string();
    if (!s) fail(key, fmt::format("holds {}; expected an array of strings", describe(element)));
    values.push_back(s->get());
  }
  return values;
}

TomlTable TomlTable::table(std::string_view key) const {
  if (!has(key)) set(key, toml::table());
  return required_table(key);
}

TomlTable TomlTable::required_table(std::string_view key) const {
  toml::node* node = table_->get(key);
  if (!node) fail(key, fmt::format("missing; expected a table [{}]", path_of(key)));
  toml::table* t = node->as_table();
  if (!t) fail(key, fmt::format("is {}; expected a table [{}]", describe(*node), path_of(key)));
  return TomlTable(*document_, *t, path_of(key), line_of(*node));
}

std::vector<TomlTable> TomlTable::tables(std::string_view key) const {
  toml::node* node = table_->get(key);
  if (!node) return {};
  toml::array* array = node->as_array();
  const std::string wanted = fmt::format("tables [[{}]]", path_of(key));
  if (!array) fail(key, fmt::format("is {}; expected {}", describe(*node), wanted));
  std::vector<TomlTable> result;
  for (std::size_t i = 0; i < array->size(); ++i) {
    toml::node& element = *array->get(i);
    toml::table* t = element.as_table();
    if (!t) fail(key, fmt::format("holds {}; expected {}", describe(element), wanted));
    result.emplace_back(*document_, *t, fmt::format("{}.{}", path_of(key), i), line_of(element));
  }
  return result;
}

std::string_view nearest(std::string_view word, const std::vector<std::string_view>& candidates) {
  return *std::ranges::min_element(
      candidates, {}, [&](std::string_view candidate) { return edit_distance(word, candidate); });
}

}  // namespace firn
