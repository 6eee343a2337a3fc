// One table of a document, and its values in SI.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/system/input_limits.h"
#include "experiments/text/suggestions.h"
#include "experiments/text/toml_document.h"
#include "experiments/text/toml_messages.h"

namespace firn {

using namespace toml_text;

namespace {

// Adds the places of the parts of a value that are not on its line. `path`: of the value.
template <class PlaceOf>
void add_part_places(const toml::node& value, const std::string& path, const PlaceOf& place_of,
                     std::map<std::string, std::string>& places) {
  const auto add = [&](std::string_view key, const toml::node& part) {
    const std::string inside = join_path(path, key);
    const bool has_line = line_of(part) > 0 && line_of(part) != line_of(value);
    if (has_line) places.emplace(inside, place_of(part));
    add_part_places(part, inside, place_of, places);
  };
  if (const toml::table* table = value.as_table()) {
    for (const auto& [key, part] : *table) add(key.str(), part);
  } else if (const toml::array* array = value.as_array()) {
    for (std::size_t i = 0; i < array->size(); ++i) add(std::to_string(i), (*array)[i]);
  }
}

}  // namespace

TomlTable::TomlTable(TomlDocument& document, toml::table& table, std::string path, unsigned line)
    : document_(&document), table_(&table), path_(std::move(path)), line_(line) {}

TomlTable TomlTable::root(TomlDocument& document) {
  return TomlTable(document, document.root(), "", 1);
}

void TomlTable::allow(std::span<const std::string_view> keys) const {
  for (const auto& [key, value] : *table_) {
    if (std::ranges::find(keys, key.str()) != keys.end()) continue;
    document_->fail(path_of(key.str()), key.source().begin.line, "unknown key",
                    suggestion(key.str(), {keys.begin(), keys.end()}));
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

bool TomlTable::is_table(std::string_view key) const {
  const toml::node* node = table_->get(key);
  return node != nullptr && node->is_table();
}

bool TomlTable::is_block_table(std::string_view key) const {
  const toml::node* node = table_->get(key);
  const toml::table* table = node == nullptr ? nullptr : node->as_table();
  return table != nullptr && !table->is_inline();
}

std::vector<std::string> TomlTable::keys() const {
  std::vector<std::string> names;
  for (const auto& [key, value] : *table_) names.emplace_back(key.str());
  return names;
}

std::string TomlTable::path_of(std::string_view key) const { return join_path(path_, key); }

unsigned TomlTable::line_of_key(std::string_view key) const {
  const toml::node* node = key.empty() ? nullptr : table_->get(key);
  return node != nullptr && line_of(*node) > 0 ? line_of(*node) : line_;
}

void TomlTable::fail(std::string_view key, const std::string& message,
                     const std::string& advice) const {
  document_->fail(path_of(key), line_of_key(key), message, advice);
}

void TomlTable::fail_element(std::string_view key, std::size_t element,
                             const std::string& message) const {
  const toml::node* node = table_->get(key);
  const toml::array* array = node == nullptr ? nullptr : node->as_array();
  const toml::node* at = array == nullptr ? nullptr : array->get(element);
  const bool has_line = at != nullptr && line_of(*at) > 0;
  try {
    document_->fail(path_of(key), has_line ? line_of(*at) : line_of_key(key), message);
  } catch (OverrideError& error) {
    if (error.of_value) error.value_part = join_path(error.value_part, std::to_string(element));
    throw;
  }
}

std::string TomlTable::place(std::string_view key) const {
  const std::string path = path_of(key);
  return fmt::format("{}:{}: {}", document_->source_of(path), std::max(line_of_key(key), 1u),
                     document_->named(path));
}

ValuePlace TomlTable::value_place(std::string_view key, std::string name) const {
  const std::string path = path_of(key), file = document_->source_of(path);
  if (name.empty()) name = document_->named(path);
  const auto place_of = [&](const toml::node& node) {
    return fmt::format("{}:{}: {}", file, line_of(node), name);
  };
  ValuePlace place{fmt::format("{}:{}: {}", file, std::max(line_of_key(key), 1u), name), {}};
  if (const toml::node* node = table_->get(key)) add_part_places(*node, "", place_of, place.parts);
  return place;
}

std::vector<ValuePlace> TomlTable::element_places(std::string_view key) const {
  const toml::node* node = table_->get(key);
  if (node == nullptr) return {};
  const toml::array* array = node->as_array();
  if (array == nullptr) return {value_place(key)};
  const std::string path = path_of(key), file = document_->source_of(path),
                    name = document_->named(path);
  const auto place_of = [&](const toml::node& at) {
    const unsigned line = line_of(at) > 0 ? line_of(at) : line_of_key(key);
    return fmt::format("{}:{}: {}", file, std::max(line, 1u), name);
  };
  std::vector<ValuePlace> places;
  places.reserve(array->size());
  for (const toml::node& element : *array) {
    ValuePlace& place = places.emplace_back(ValuePlace{place_of(element), {}});
    add_part_places(element, "", place_of, place.parts);
  }
  return places;
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
  constexpr int kMost = 1'000'000'000;  // so that the sum of two is a whole number, too
  return static_cast<int>(integer64(key, least, kMost));
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
  if (std::abs(d) > usable_range(dimension::none).largest)
    fail(key, fmt::format("is {}; expected a number up to {:g}", d,
                          usable_range(dimension::none).largest));
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
  if (const double least = usable_range(dimension).smallest;
      sign == Sign::positive && value > 0 && value < least)
    fail(key, fmt::format("is {}; expected {} of at least {}", describe(*table_->get(key)),
                          dimension_name(dimension), si_text(least, dimension)));
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
    values.push_back(
        at_element(key, values.size(), [&] { return parse_quantity(one, dimension); }));
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
  if (v.minCoeff() <= 0)
    fail(key, fmt::format("is {}; expected three lengths above zero", describe(*table_->get(key))));
  if (const double least = usable_range(dimension::length).smallest; v.minCoeff() < least)
    fail(key, fmt::format("is {}; expected three lengths of at least {}",
                          describe(*table_->get(key)), si_text(least, dimension::length)));
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
      fail_element(key, values.size(),
                   fmt::format("holds {}; expected {}", describe(element), wanted));
    }
    values.push_back(*d);
  }
  if (values.size() != count) {
    fail(key, fmt::format("has {} entries; expected {}", values.size(), wanted));
  }
  return values;
}

std::array<double, 2> TomlTable::pair(std::string_view key) const {
  const auto n = numbers(key, 2, "two numbers [a, b]");
  return {n[0], n[1]};
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
      fail_element(key, values.size(),
                   fmt::format("holds {}; expected {}", describe(element), kWanted));
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
      fail_element(key, i, fmt::format("holds {}; expected {}", n[i], kWanted));
    }
    counts[i] = static_cast<int>(n[i]);
  }
  return counts;
}

std::vector<std::array<int, 2>> TomlTable::integer_pairs(std::string_view key) const {
  constexpr const char* kWanted = "pairs of whole numbers, [[0, 1], [1, 2]]";
  const toml::array* list = require(key).as_array();
  if (!list) fail(key, fmt::format("is {}; expected {}", describe(require(key)), kWanted));
  if (list->size() > input_limits::bonded_pairs)
    fail(key, fmt::format("has {} entries; expected at most {}", list->size(),
                          input_limits::bonded_pairs));
  std::vector<std::array<int, 2>> pairs;
  for (const toml::node& element : *list) {
    const toml::array* pair = element.as_array();
    if (!pair || pair->size() != 2)
      fail_element(key, pairs.size(),
                   fmt::format("holds {}; expected {}", describe(element), kWanted));
    std::array<int, 2>& out = pairs.emplace_back();
    for (std::size_t k = 0; k < 2; ++k) {
      const auto n = (*pair)[k].value_exact<std::int64_t>();
      if (!n || *n < 0 || *n > std::numeric_limits<int>::max())
        fail_element(key, pairs.size() - 1,
                     fmt::format("holds {}; expected {}", describe((*pair)[k]), kWanted));
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

std::vector<std::string> TomlTable::strings(std::string_view key, const std::string& wanted) const {
  if (!has(key)) return {};
  const toml::node& node = require(key);
  const toml::array* array = node.as_array();
  if (!array) fail(key, fmt::format("is {}; expected {}", describe(node), wanted));
  std::vector<std::string> values;
  for (const toml::node& element : *array) {
    const auto* s = element.as_string();
    if (!s)
      fail_element(key, values.size(),
                   fmt::format("holds {}; expected {}", describe(element), wanted));
    values.push_back(s->get());
  }
  return values;
}

void TomlTable::require_at_most(std::string_view key, std::size_t most) const {
  const toml::node* node = table_->get(key);
  const toml::table* t = node == nullptr ? nullptr : node->as_table();
  if (t != nullptr && t->size() > most)
    fail(key, fmt::format("has {} entries; expected at most {}", t->size(), most));
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
  const std::size_t most =
      key == "particles" ? input_limits::placed_tables : input_limits::list_tables;
  if (array->size() > most)
    fail(key, fmt::format("holds {} tables; expected at most {}", array->size(), most));
  std::vector<TomlTable> result;
  for (std::size_t i = 0; i < array->size(); ++i) {
    toml::node& element = *array->get(i);
    toml::table* t = element.as_table();
    if (!t) fail(key, fmt::format("holds {}; expected {}", describe(element), wanted));
    result.emplace_back(*document_, *t, fmt::format("{}.{}", path_of(key), i), line_of(element));
  }
  return result;
}

}  // namespace firn
