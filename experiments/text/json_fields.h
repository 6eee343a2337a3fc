// Structs that JSON files hold as objects. Each lists its keys once, for writing and for reading:
//
//   template <class Fields>
//   void fields(Fields& f) {
//     f.required("mean", mean);
//     f.optional("unit", unit);
//   }
//
// `required`: in every file. `added`: written always, but files of earlier versions may lack it.
// `optional`: written unless it is empty (a string, a list, a std::optional). A std::optional that
// is `required` or `added` is null where it is empty. What a file lacks stays as it is in the
// struct; keys that no struct lists are ignored.
#pragma once

#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

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

class JsonFieldWriter {
 public:
  using Json = nlohmann::ordered_json;

  template <class T>
  void required(const char* key, T& value) {
    object_[key] = json_of(value);
  }
  template <class T>
  void added(const char* key, T& value) {
    required(key, value);
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
  static Json json_of(NamedValues<T>& values) {
    Json object = Json::object();
    for (auto& [name, value] : values) object[name] = json_of(value);
    return object;
  }
  template <class T>
  static Json json_of(T& value) {
    if constexpr (requires(JsonFieldWriter & writer) { value.fields(writer); }) {
      JsonFieldWriter writer;
      value.fields(writer);
      return std::move(writer.object_);
    } else {
      return value;  // bool, whole number, text
    }
  }

 private:
  Json object_ = Json::object();
};

// Where a value is in a file.
struct JsonPlace {
  const std::string& file;
  const JsonPlace* parent = nullptr;  // null: the document itself, of name `key` if it has one
  std::string_view key = {};
  std::size_t index = 0;  // in a list, where `key` is empty

  // Throws InputError `FILE: PATH: is X; expected Y`.
  [[noreturn]] void refuse(const nlohmann::ordered_json& found, std::string_view expected) const;
  [[noreturn]] void refuse_missing(std::string_view missing) const;
};

// Everything throws InputError that names file, place and what is expected.
class JsonFieldReader {
 public:
  using Json = nlohmann::ordered_json;

  JsonFieldReader(const Json& object, const JsonPlace& place) : object_(object), place_(place) {
    if (!object.is_object()) place.refuse(object, "an object");
  }

  template <class T>
  void required(const char* key, T& value) {
    const auto found = object_.find(key);
    if (found == object_.end()) place_.refuse_missing(key);
    read(*found, {place_.file, &place_, key}, value);
  }
  template <class T>
  void added(const char* key, T& value) {
    const auto found = object_.find(key);
    if (found != object_.end()) read(*found, {place_.file, &place_, key}, value);
  }
  template <class T>
  void optional(const char* key, T& value) {
    added(key, value);
  }
  template <class T>
  void optional(const char* key, std::optional<T>& value) {
    if (object_.contains(key)) required(key, value.emplace(T()));
  }

  // NaN for null. Numbers up to 1e100, so that products of several stay finite.
  static void read(const Json& json, const JsonPlace& place, double& value);
  static void read(const Json& json, const JsonPlace& place, bool& value);
  static void read(const Json& json, const JsonPlace& place, std::string& value);
  static void read(const Json& json, const JsonPlace& place, int& value);  // up to a billion
  static void read(const Json& json, const JsonPlace& place, std::uint64_t& value);

  template <class T>
  static void read(const Json& json, const JsonPlace& place, std::optional<T>& value) {
    value.reset();
    if (!json.is_null()) read(json, place, value.emplace());
  }
  template <class T>
  static void read(const Json& json, const JsonPlace& place, std::pair<T, T>& both) {
    if (!json.is_array() || json.size() != 2) place.refuse(json, "a list of 2");
    read(json.front(), {place.file, &place, {}, 0}, both.first);
    read(json.back(), {place.file, &place, {}, 1}, both.second);
  }
  template <class T>
  static void read(const Json& json, const JsonPlace& place, std::vector<T>& values) {
    if (!json.is_array()) place.refuse(json, "a list");
    values.clear();
    values.reserve(json.size());
    for (const Json& item : json) {
      const std::size_t index = values.size();
      read(item, {place.file, &place, {}, index}, values.emplace_back());
    }
  }
  template <class T>
  static void read(const Json& json, const JsonPlace& place, NamedValues<T>& values) {
    if (!json.is_object()) place.refuse(json, "an object");
    values.clear();
    for (const auto& [name, item] : json.items())
      read(item, {place.file, &place, name}, values.emplace_back(name, T()).second);
  }
  template <class T>
  static void read(const Json& json, const JsonPlace& place, T& value) {
    JsonFieldReader reader(json, place);
    value.fields(reader);
  }

 private:
  const Json& object_;
  const JsonPlace& place_;
};

template <class T>
T document_from_json(const nlohmann::ordered_json& json, const std::string& file) {
  T document;
  JsonFieldReader::read(json, {file}, document);
  return document;
}

// JSON text of a document; `indent`: columns of a level, -1: one line. By value: writing takes what
// can be changed. Bytes that are no UTF-8 become U+FFFD.
template <class T>
std::string json_text(T document, int indent) {
  return JsonFieldWriter::json_of(document).dump(indent, ' ', false,
                                                 nlohmann::ordered_json::error_handler_t::replace);
}

// A parsed results.json of Firn.
struct ResultsJson {
  std::string file;
  nlohmann::ordered_json document;  // in current names

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
  return document_from_json<T>(results.document, results.file);
}

}  // namespace firn
