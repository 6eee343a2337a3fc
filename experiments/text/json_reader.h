// Strict reading of JSON, as toml_document.h does of TOML: every key is known, typed and checked,
// and every complaint has a place.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace firn {

// Throws InputError `SOURCE:LINE: JSON: ...` for text that is no JSON, that has a key twice, or
// that is beyond the limits of input_limits.h.
nlohmann::json parse_json(std::string_view text, const std::string& source);
nlohmann::ordered_json parse_ordered_json(std::string_view text, const std::string& source);

// One value of a document, which must outlive it. Everything throws InputError
// `SOURCE: PATH: what is wrong; what is expected`; missing keys are those that are null, too.
class JsonReader {
 public:
  JsonReader(const nlohmann::json& json, const std::string& source, std::string path = {})
      : json_(&json), source_(&source), path_(std::move(path)) {}

  // The value is an object with no other keys than these.
  void allow(std::initializer_list<std::string_view> keys) const;
  bool has(std::string_view key) const;
  JsonReader at(std::string_view key) const;
  std::vector<JsonReader> items(std::string_view key) const;  // of an array; none when missing

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
