#include "experiments/text/json_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "experiments/system/input_limits.h"
#include "experiments/system/text_encoding.h"
#include "experiments/text/toml_document.h"

namespace firn {
namespace {

using Json = nlohmann::json;

// How messages call a value of the wrong type.
std::string json_type(const Json& json) {
  if (json.is_string()) return fmt::format("\"{}\"", json.get_ref<const std::string&>());
  if (json.is_number_float()) return fmt::format("the number {}", json.get<double>());
  if (json.is_number()) return "the number " + json.dump();
  if (json.is_object()) return "an object";
  if (json.is_array()) return "an array";
  return json.dump();
}

std::size_t line_at(std::string_view text, std::size_t byte) {
  const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min(byte, text.size()));
  return 1 + static_cast<std::size_t>(std::count(text.begin(), end, '\n'));
}

// Stops the parser.
struct Refused {
  std::string what;
};

template <class Document>
Document parse_checked(std::string_view text, const std::string& source) {
  using Event = typename Document::parse_event_t;
  std::vector<std::set<std::string>> keys;  // of the objects that are open
  std::string key;                          // read last
  const auto check_text = [&](const std::string& text, bool one_line) {
    const std::string found =
        one_line ? encode::first_unprintable(text) : encode::first_control(text);
    if (!found.empty())
      throw InputError(fmt::format("{}: {}: has the character {}; expected printable text", source,
                                   encode::terminal(key), found));
  };
  const auto watch = [&](int depth, Event event, Document& parsed) {
    if (depth > input_limits::json_depth)
      throw Refused{fmt::format("arrays and objects are nested more than {} deep; expected fewer",
                                input_limits::json_depth)};
    if (event == Event::key) {
      key = parsed.template get<std::string>();
      check_text(key, true);
    }
    if (event == Event::value && parsed.is_string())
      check_text(parsed.template get_ref<const std::string&>(), key == "name" || key == "title");
    if (event == Event::object_start) keys.emplace_back();
    if (event == Event::object_end) keys.pop_back();
    if (event == Event::key && !keys.back().insert(key).second)
      throw Refused{
          fmt::format("the key \"{}\" stands twice in one object; expected it once", key)};
    if (event == Event::key && keys.back().size() > input_limits::json_keys)
      throw Refused{
          fmt::format("an object has more than {} keys; expected fewer", input_limits::json_keys)};
    return true;
  };
  try {
    return Document::parse(text, watch);
  } catch (const typename Document::parse_error& e) {
    throw InputError(fmt::format("{}:{}: JSON: no JSON from here on; expected valid JSON in UTF-8",
                                 source, line_at(text, e.byte)));
  } catch (const typename Document::exception&) {  // a number beyond all doubles
    throw InputError(fmt::format(
        "{}:1: JSON: holds a number that no computer can; expected finite numbers", source));
  } catch (const Refused& refused) {
    throw InputError(fmt::format("{}:1: JSON: {}", source, refused.what));
  }
}

}  // namespace

Json parse_json(std::string_view text, const std::string& source) {
  return parse_checked<Json>(text, source);
}

nlohmann::ordered_json parse_ordered_json(std::string_view text, const std::string& source) {
  return parse_checked<nlohmann::ordered_json>(text, source);
}

void JsonReader::fail(const std::string& message) const {
  throw InputError(
      fmt::format("{}: {}: {}", *source_, path_.empty() ? "document" : path_, message));
}

void JsonReader::allow(std::span<const std::string_view> keys) const {
  if (!json_->is_object()) fail(fmt::format("is {}; expected an object", json_type(*json_)));
  for (const auto& [key, value] : json_->items()) {
    if (std::ranges::find(keys, key) != keys.end()) continue;
    fail(fmt::format("unknown key \"{}\"; the nearest known one is \"{}\"", key,
                     nearest(key, {keys.begin(), keys.end()})));
  }
}

bool JsonReader::has(std::string_view key) const {
  const auto it = json_->find(key);
  return it != json_->end() && !it->is_null();
}

const Json& JsonReader::require(std::string_view key, const char* wanted) const {
  if (!has(key)) {
    const std::string place = path_.empty() ? std::string(key) : fmt::format("{}.{}", path_, key);
    throw InputError(fmt::format("{}: {}: missing; expected {}", *source_, place, wanted));
  }
  return *json_->find(key);
}

JsonReader JsonReader::at(std::string_view key) const {
  return {require(key, "this key"), *source_,
          path_.empty() ? std::string(key) : fmt::format("{}.{}", path_, key)};
}

std::vector<JsonReader> JsonReader::items(std::string_view key) const {
  if (!has(key)) return {};
  const JsonReader all = at(key);
  if (!all.json_->is_array())
    all.fail(fmt::format("is {}; expected an array", json_type(*all.json_)));
  std::vector<JsonReader> readers;
  for (std::size_t i = 0; i < all.json_->size(); ++i)
    readers.emplace_back((*all.json_)[i], *source_, fmt::format("{}.{}", all.path_, i));
  return readers;
}

std::string JsonReader::text() const {
  if (!json_->is_string()) fail(fmt::format("is {}; expected a string", json_type(*json_)));
  return json_->get<std::string>();
}

double JsonReader::finite() const {
  if (!json_->is_number()) fail(fmt::format("is {}; expected a number", json_type(*json_)));
  const double value = json_->get<double>();
  if (!std::isfinite(value)) fail(fmt::format("is {}; expected a finite number", value));
  return value;
}

std::string JsonReader::string(std::string_view key) const {
  require(key, "a string");
  return at(key).text();
}

std::string JsonReader::string_or_empty(std::string_view key) const {
  return has(key) ? at(key).text() : std::string();
}

double JsonReader::number(std::string_view key) const {
  require(key, "a number");
  return at(key).finite();
}

std::optional<double> JsonReader::optional_number(std::string_view key) const {
  if (!has(key)) return std::nullopt;
  return at(key).finite();
}

std::int64_t JsonReader::integer(std::string_view key, std::int64_t least,
                                 std::int64_t most) const {
  const Json& json = require(key, "a whole number");
  // A number beyond 63 bits is unsigned, and too large for anything here.
  const bool fits = json.is_number_integer() &&
                    !(json.is_number_unsigned() &&
                      json.get<std::uint64_t>() > static_cast<std::uint64_t>(most)) &&
                    json.get<std::int64_t>() >= least;
  if (!fits)
    at(key).fail(
        fmt::format("is {}; expected a whole number from {} to {}", json_type(json), least, most));
  return json.get<std::int64_t>();
}

bool JsonReader::boolean(std::string_view key) const {
  const Json& json = require(key, "true or false");
  if (!json.is_boolean())
    at(key).fail(fmt::format("is {}; expected true or false", json_type(json)));
  return json.get<bool>();
}

std::vector<double> JsonReader::numbers() const {
  if (!json_->is_array()) fail(fmt::format("is {}; expected an array", json_type(*json_)));
  std::vector<double> values;
  for (std::size_t i = 0; i < json_->size(); ++i)
    values.push_back(JsonReader((*json_)[i], *source_, fmt::format("{}.{}", path_, i)).finite());
  return values;
}

std::uint64_t JsonReader::whole_number() const {
  if (!json_->is_number_unsigned())
    fail(fmt::format("is {}; expected a whole number of at least 0", json_type(*json_)));
  return json_->get<std::uint64_t>();
}

std::vector<double> JsonReader::numbers(std::string_view key) const {
  require(key, "an array of numbers");
  return at(key).numbers();
}

std::vector<std::string> JsonReader::strings(std::string_view key) const {
  std::vector<std::string> values;
  for (const JsonReader& item : items(key)) values.push_back(item.text());
  return values;
}

std::map<std::string, std::string> JsonReader::texts(std::string_view key) const {
  const JsonReader object = at(key);
  if (!object.json_->is_object())
    object.fail(fmt::format("is {}; expected an object", json_type(*object.json_)));
  std::map<std::string, std::string> texts;
  for (const auto& item : object.json_->items()) texts[item.key()] = object.string(item.key());
  return texts;
}

void read_key(const JsonReader& j, const char* key, std::string& value) { value = j.string(key); }
void read_key(const JsonReader& j, const char* key, double& value) { value = j.number(key); }
void read_key(const JsonReader& j, const char* key, bool& value) { value = j.boolean(key); }
void read_key(const JsonReader& j, const char* key, std::uint64_t& value) {
  value = j.at(key).whole_number();
}
void read_key(const JsonReader& j, const char* key, WholeNumber& number) {
  number.value = static_cast<int>(j.integer(key, 1, number.most));
}
void read_key(const JsonReader& j, const char* key, std::vector<double>& values) {
  values = j.numbers(key);
}
void read_key(const JsonReader& j, const char* key, std::vector<std::string>& values) {
  values = j.strings(key);
}
void read_key(const JsonReader& j, const char* key, std::vector<std::uint64_t>& values) {
  for (const JsonReader& item : j.items(key)) values.push_back(item.whole_number());
}
void read_key(const JsonReader& j, const char* key, std::vector<std::vector<double>>& rows) {
  for (const JsonReader& row : j.items(key)) rows.push_back(row.numbers());
}
void read_key(const JsonReader& j, const char* key, std::map<std::string, std::string>& texts) {
  texts = j.texts(key);
}

}  // namespace firn
