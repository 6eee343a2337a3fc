// Strict reading of JSON, as toml_document.h for TOML: unknown keys are errors, values are checked
// for type and range, and error messages state the position. Types that are written as well list
// their keys once:
//
//   void fields(StrictFields& f, Sample& s) {
//     f.required("values", s.values);
//     f.optional("note", s.note);
//   }
//
// json_of(s) writes such an object, and read_object(reader, s) reads it. Other types get functions
// json_of() and read_key() in their namespace.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace firn {

// Throws InputError `SOURCE:LINE: JSON: ...` for text that is not JSON, has a key twice, or exceeds
// the limits of input_limits.h.
nlohmann::json parse_json(std::string_view text, const std::string& source);
nlohmann::ordered_json parse_ordered_json(std::string_view text, const std::string& source);

// One value of a document. The document must outlive the reader. All functions throw InputError
// `SOURCE: PATH: FAULT; EXPECTATION`. A key with the value null counts as missing.
class JsonReader {
 public:
  JsonReader(const nlohmann::json& json, const std::string& source, std::string path = {})
      : json_(&json), source_(&source), path_(std::move(path)) {}

  // Throws unless the value is an object whose keys are all in `keys`.
  void allow(std::span<const std::string_view> keys) const;
  void allow(std::initializer_list<std::string_view> keys) const {
    allow(std::span(keys.begin(), keys.size()));
  }
  bool has(std::string_view key) const;
  JsonReader at(std::string_view key) const;
  std::vector<JsonReader> items(
      std::string_view key) const;  // elements of an array; empty if missing

  std::string string(std::string_view key) const;
  std::string string_or_empty(std::string_view key) const;
  double number(std::string_view key) const;
  std::optional<double> optional_number(std::string_view key) const;
  std::int64_t integer(std::string_view key, std::int64_t least, std::int64_t most) const;
  bool boolean(std::string_view key) const;
  std::vector<double> numbers(std::string_view key) const;
  std::vector<std::string> strings(std::string_view key) const;
  std::map<std::string, std::string> texts(std::string_view key) const;  // an object

  // The value itself.
  std::vector<double> numbers() const;
  std::uint64_t whole_number() const;

  [[noreturn]] void fail(const std::string& message) const;
  const std::string& path() const { return path_; }

 private:
  const nlohmann::json& require(std::string_view key, const char* wanted) const;
  std::string text() const;
  double finite() const;

  const nlohmann::json* json_;
  const std::string* source_;
  std::string path_;
};

// The keys of an object, for writing or for reading.
class StrictFields {
 public:
  using Json = nlohmann::ordered_json;

  explicit StrictFields(Json& written) : written_(&written) {}
  explicit StrictFields(const JsonReader& read) : read_(&read) {}
  explicit StrictFields(std::vector<std::string_view>& keys) : keys_(&keys) {}

  // True while all keys are listed, whatever the values are.
  bool lists_keys() const { return keys_ != nullptr; }

  template <class T>
  void required(const char* key, T&& value);
  // Written on this condition; read where the file has it.
  template <class T>
  void written_if(bool written, const char* key, T&& value) {
    if (lists_keys() || (written_ != nullptr ? written : read_->has(key))) required(key, value);
  }
  // Written unless it is empty.
  template <class T>
  void optional(const char* key, std::optional<T>& value) {
    written_if(value.has_value(), key, value);
  }
  template <class T>
  void optional(const char* key, T& value) {
    written_if(!value.empty(), key, value);
  }

 private:
  Json* written_ = nullptr;
  const JsonReader* read_ = nullptr;
  std::vector<std::string_view>* keys_ = nullptr;
};

// A whole number from 1 on.
struct WholeNumber {
  int& value;
  int most = 1000000;
};

template <class T>
nlohmann::ordered_json json_of(T& value) {
  if constexpr (requires(StrictFields & f) { fields(f, value); }) {
    nlohmann::ordered_json object = nlohmann::ordered_json::object();
    StrictFields f(object);
    fields(f, value);
    return object;
  } else {
    return value;  // texts, numbers, and lists and maps of these
  }
}
inline nlohmann::ordered_json json_of(WholeNumber& number) { return number.value; }
template <class T>
nlohmann::ordered_json json_of(std::optional<T>& value) {
  return json_of(*value);
}
template <class T>
nlohmann::ordered_json json_of(std::vector<T>& values) {
  nlohmann::ordered_json array = nlohmann::ordered_json::array();
  for (T& value : values) array.push_back(json_of(value));
  return array;
}

// `extra`: a key that the object may have in addition.
template <class T>
void read_object(const JsonReader& j, T& value, std::string_view extra = {}) {
  std::vector<std::string_view> keys;
  StrictFields list(keys);
  fields(list, value);
  if (!extra.empty()) keys.push_back(extra);
  j.allow(keys);
  StrictFields f(j);
  fields(f, value);
}

void read_key(const JsonReader& j, const char* key, std::string& value);
void read_key(const JsonReader& j, const char* key, double& value);
void read_key(const JsonReader& j, const char* key, bool& value);
void read_key(const JsonReader& j, const char* key, std::uint64_t& value);
void read_key(const JsonReader& j, const char* key, WholeNumber& number);
void read_key(const JsonReader& j, const char* key, std::vector<double>& values);
void read_key(const JsonReader& j, const char* key, std::vector<std::string>& values);
void read_key(const JsonReader& j, const char* key, std::vector<std::uint64_t>& values);
void read_key(const JsonReader& j, const char* key, std::vector<std::vector<double>>& rows);
void read_key(const JsonReader& j, const char* key, std::map<std::string, std::string>& texts);
template <class T>
void read_key(const JsonReader& j, const char* key, T& value) {
  read_object(j.at(key), value);
}
template <class T>
void read_key(const JsonReader& j, const char* key, std::vector<T>& values) {
  for (const JsonReader& item : j.items(key)) read_object(item, values.emplace_back());
}
template <class T>
void read_key(const JsonReader& j, const char* key, std::optional<T>& value) {
  read_key(j, key, value.emplace());
}

template <class T>
void StrictFields::required(const char* key, T&& value) {
  if (keys_ != nullptr)
    keys_->emplace_back(key);
  else if (written_ != nullptr)
    (*written_)[key] = json_of(value);
  else
    read_key(*read_, key, value);
}

}  // namespace firn
