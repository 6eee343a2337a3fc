// Strict reading of JSON, as toml_document.h for TOML: unknown keys are errors, values are checked
// for type and range, and error messages state the position.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
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
  void allow(std::initializer_list<std::string_view> keys) const;
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

}  // namespace firn
