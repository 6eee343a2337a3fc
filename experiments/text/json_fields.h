// Structs that JSON files hold as objects. Each lists its keys once, for writing and for reading:
//
//   template <class Fields>
//   void fields(Fields& f) {
//     f.required("mean", mean);
//     f.optional("unit", unit);
//   }
//
// or, for a struct that does not depend on JSON, in a function fields(Fields&, Struct&) of its
// namespace.
//
// `required`: in every file. `required_if`: in every file on a condition, which may depend on the
// fields before it. `added`: written always, but files of earlier versions may lack it. `optional`:
// written unless it is empty (a string, a list, a std::optional). `written_if`: written on a
// condition, read where a file has it. A std::optional that is `required` or `added` is null where
// it is empty. What a file lacks stays as it is in the struct.
//
// A type that is one value of JSON, such as an enumeration, has two functions in its namespace:
// `Json json_value(T&)` and `void read_json_value(const Json&, const JsonPlace&, T&)`.
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "experiments/text/json_parser.h"
#include "experiments/text/vector_json.h"

namespace firn {

// An object whose keys are names of the user's, in the order of the file.
template <class T>
using NamedValues = std::vector<std::pair<std::string, T>>;

// The first of that name; null: none.
template <class T>
const T* find_named(const NamedValues<T>& values, std::string_view name) {
  for (const auto& [key, value] : values)
    if (key == name) return &value;
  return nullptr;
}

// A whole number from 1 on.
struct PositiveInt {
  int& value;
  int most = 1'000'000;
};

template <class Fields, class T>
concept HasJsonFields = requires(Fields& f, T& value) {
  value.fields(f);
}
|| requires(Fields& f, T& value) { fields(f, value); };

template <class Fields, class T>
void visit_json_fields(Fields& f, T& value) {
  if constexpr (requires { value.fields(f); })
    value.fields(f);
  else
    fields(f, value);
}

class JsonFieldWriter {
 public:
  using Json = nlohmann::ordered_json;

  template <class T>
  void required(const char* key, T&& value) {
    object_[key] = json_of(value);
  }
  template <class T>
  void required_if(bool condition, const char* key, T&& value) {
    if (condition) required(key, value);
  }
  template <class T>
  void added(const char* key, T& value) {
    required(key, value);
  }
  template <class T>
  void written_if(bool condition, const char* key, T&& value) {
    if (condition) required(key, value);
  }
  template <class T>
  void optional(const char* key, T& value) {
    if (!value.empty()) required(key, value);
  }
  template <class T>
  void optional(const char* key, std::optional<T>& value) {
    if (value) required(key, *value);
  }

  // null for a number that is not finite.
  static Json json_of(double value) { return number_json(value); }
  static Json json_of(PositiveInt& number) { return number.value; }
  template <class T>
  static Json json_of(std::optional<T>& value) {
    return value ? json_of(*value) : Json();
  }
  template <class T>
  static Json json_of(std::pair<T, T>& both) {
    return Json::array({json_of(both.first), json_of(both.second)});
  }
  template <class T>
  static Json json_of(std::vector<T>& values) {
    Json list = Json::array();
    for (T& value : values) list.push_back(json_of(value));
    return list;
  }
  template <class T>
  static Json json_of(std::map<std::string, T>& values) {
    Json object = Json::object();
    for (auto& [name, value] : values) object[name] = json_of(value);
    return object;
  }
  template <class T>
  static Json json_of(NamedValues<T>& values) {
    Json object = Json::object();
    for (auto& [name, value] : values) object[name] = json_of(value);
    return object;
  }
  template <class T>
  static Json json_of(T& value) {
    if constexpr (HasJsonFields<JsonFieldWriter, T>) {
      JsonFieldWriter writer;
      visit_json_fields(writer, value);
      return std::move(writer.object_);
    } else if constexpr (requires { json_value(value); }) {
      return json_value(value);
    } else {
      return value;  // bool, whole number, text
    }
  }

 private:
  Json object_ = Json::object();
};

// All keys of a struct, whatever its values are.
class JsonFieldNames {
 public:
  template <class T>
  void required(const char* key, T&&) {
    names.emplace_back(key);
  }
  template <class T>
  void required_if(bool, const char* key, T&&) {
    names.emplace_back(key);
  }
  template <class T>
  void added(const char* key, T&) {
    names.emplace_back(key);
  }
  template <class T>
  void written_if(bool, const char* key, T&&) {
    names.emplace_back(key);
  }
  template <class T>
  void optional(const char* key, T&) {
    names.emplace_back(key);
  }

  std::vector<std::string_view> names;
};

enum class JsonReading {
  tolerant,  // documents of any version of Firn: ignores unknown keys; null is NaN for a number,
             // and numbers reach up to 1e100, so that products of several stay finite
  strict,    // files that users write: refuses unknown keys; null counts as missing where a key is
             // not required, and is no number
};

// Where a value is in a file.
struct JsonPlace {
  const std::string& file;
  JsonReading reading = JsonReading::tolerant;
  const JsonPlace* parent = nullptr;  // null: the document itself, of name `key` if it has one
  std::string_view key = {};
  std::size_t index = 0;  // in a list, where `key` is empty
  // Of the document itself: the text that was parsed. Empty: messages have no lines.
  std::string_view text = {};

  JsonPlace at(std::string_view name) const { return {file, reading, this, name}; }
  JsonPlace at(std::size_t item) const { return {file, reading, this, {}, item}; }

  // Throws InputError `FILE:LINE: PATH: is X; expected Y`. Of a missing value: the line of the
  // object that lacks it.
  [[noreturn]] void refuse(const nlohmann::ordered_json& found, std::string_view expected) const;
  [[noreturn]] void refuse_missing(std::string_view missing) const;
  // Throws InputError for a key of the object that is none of `known`.
  void refuse_unknown_keys(const nlohmann::ordered_json& object,
                           const std::vector<std::string_view>& known) const;
};

// Everything throws InputError that names file, place and what is expected.
class JsonFieldReader {
 public:
  using Json = nlohmann::ordered_json;

  JsonFieldReader(const Json& object, const JsonPlace& place) : object_(object), place_(place) {
    if (!object.is_object()) place.refuse(object, "an object");
  }

  template <class T>
  void required(const char* key, T&& value) {
    const auto found = object_.find(key);
    if (found == object_.end()) place_.refuse_missing(key);
    read(*found, place_.at(key), value);
  }
  template <class T>
  void required_if(bool condition, const char* key, T&& value) {
    if (condition) required(key, value);
  }
  template <class T>
  void added(const char* key, T& value) {
    if (has(key)) required(key, value);
  }
  template <class T>
  void written_if(bool, const char* key, T&& value) {
    added(key, value);
  }
  template <class T>
  void optional(const char* key, T& value) {
    added(key, value);
  }
  template <class T>
  void optional(const char* key, std::optional<T>& value) {
    if (has(key)) required(key, value.emplace(T()));
  }

  static void read(const Json& json, const JsonPlace& place, double& value);
  static void read(const Json& json, const JsonPlace& place, bool& value);
  static void read(const Json& json, const JsonPlace& place, std::string& value);
  static void read(const Json& json, const JsonPlace& place, int& value);  // up to a billion
  static void read(const Json& json, const JsonPlace& place, PositiveInt& number);
  static void read(const Json& json, const JsonPlace& place, std::uint64_t& value);

  template <class T>
  static void read(const Json& json, const JsonPlace& place, std::optional<T>& value) {
    value.reset();
    if (!json.is_null()) read(json, place, value.emplace());
  }
  template <class T>
  static void read(const Json& json, const JsonPlace& place, std::pair<T, T>& both) {
    if (!json.is_array() || json.size() != 2) place.refuse(json, "a list of 2");
    read(json.front(), place.at(std::size_t{0}), both.first);
    read(json.back(), place.at(std::size_t{1}), both.second);
  }
  template <class T>
  static void read(const Json& json, const JsonPlace& place, std::vector<T>& values) {
    if (!json.is_array()) place.refuse(json, "a list");
    values.clear();
    values.reserve(json.size());
    for (const Json& item : json) {
      const std::size_t index = values.size();
      read(item, place.at(index), values.emplace_back());
    }
  }
  template <class T>
  static void read(const Json& json, const JsonPlace& place, std::map<std::string, T>& values) {
    if (!json.is_object()) place.refuse(json, "an object");
    values.clear();
    for (const auto& [name, item] : json.items()) read(item, place.at(name), values[name]);
  }
  template <class T>
  static void read(const Json& json, const JsonPlace& place, NamedValues<T>& values) {
    if (!json.is_object()) place.refuse(json, "an object");
    values.clear();
    for (const auto& [name, item] : json.items())
      read(item, place.at(name), values.emplace_back(name, T()).second);
  }
  template <class T>
  static void read(const Json& json, const JsonPlace& place, T& value) {
    if constexpr (requires { read_json_value(json, place, value); }) {
      read_json_value(json, place, value);
    } else {
      JsonFieldReader reader(json, place);
      if (place.reading == JsonReading::strict) {
        JsonFieldNames known;
        visit_json_fields(known, value);
        place.refuse_unknown_keys(json, known.names);
      }
      visit_json_fields(reader, value);
    }
  }

 private:
  bool has(const char* key) const {
    const auto found = object_.find(key);
    return found != object_.end() && !(found->is_null() && place_.reading == JsonReading::strict);
  }

  const Json& object_;
  const JsonPlace& place_;
};

// `text` that was parsed, for lines in messages; empty: messages without lines.
template <class T>
T document_from_json(const nlohmann::ordered_json& json, const std::string& file,
                     JsonReading reading = JsonReading::tolerant, std::string_view text = {}) {
  T document;
  JsonFieldReader::read(json, {file, reading, nullptr, {}, 0, text}, document);
  return document;
}
template <class T>
T document_from_json(const JsonFile& file, JsonReading reading = JsonReading::tolerant) {
  return document_from_json<T>(file.document, file.file, reading, file.text);
}

// JSON text of a document; `indent`: columns of a level, -1: one line. By value: writing takes what
// can be changed. Bytes that are no UTF-8 become U+FFFD.
template <class T>
std::string json_text(T document, int indent) {
  return JsonFieldWriter::json_of(document).dump(indent, ' ', false,
                                                 nlohmann::ordered_json::error_handler_t::replace);
}

// A results.json of Firn, its document in current names.
struct ResultsJson : JsonFile {
  // "sweep", "validation", "optimization" or "study"; empty for a document of no such kind.
  std::string kind() const;
  // Throws InputError for another kind. `command`: the command that writes it, for the message.
  void require_kind(const std::string& wanted, const std::string& command) const;
};

// Throws InputError for a file that cannot be read or is longer than input_limits.h says.
// `expected`: for the message.
ResultsJson read_results_json(
    const std::string& file,
    const std::string& expected = "the results.json of a study, validation, sweep or optimization");

// The document in a file of this kind. Throws InputError.
template <class T>
T document_from_results(const ResultsJson& results, const std::string& kind,
                        const std::string& command) {
  results.require_kind(kind, command);
  return document_from_json<T>(results);
}

}  // namespace firn
