// Paths, lines and values of a TOML document in messages.
#pragma once

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

namespace firn::toml_text {

// "PATH.KEY"; either part may be empty.
inline std::string join_path(std::string_view path, std::string_view key) {
  if (path.empty()) return std::string(key);
  if (key.empty()) return std::string(path);
  return fmt::format("{}.{}", path, key);
}

// A key as a dotted path states it: in quotes where TOML requires them.
inline std::string path_key(const std::string& key) {
  const bool is_bare = std::ranges::all_of(
      key, [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '-'; });
  if (is_bare) return key;
  std::string text = "\"";
  for (const char c : key) {
    if (c == '"' || c == '\\') text += '\\';
    text += c;
  }
  return text + '"';
}

inline unsigned line_of(const toml::node& node) { return node.source().begin.line; }

// Description of a value of the wrong type: "the bare number 3".
inline std::string describe(const toml::node& node) {
  if (const auto s = node.value_exact<std::string>()) return fmt::format("\"{}\"", *s);
  if (const auto i = node.value_exact<std::int64_t>()) return fmt::format("the bare number {}", *i);
  if (const auto d = node.value_exact<double>())  // 2.0 is not an integer in TOML
    return *d == std::floor(*d) && std::abs(*d) < 1e15 ? fmt::format("the bare number {:.1f}", *d)
                                                       : fmt::format("the bare number {}", *d);
  if (const auto b = node.value_exact<bool>()) return *b ? "true" : "false";
  if (node.is_array_of_tables()) return "an array of tables";
  if (node.is_array()) return "an array";
  if (node.is_table()) return "a table";
  return "a date or time";
}

}  // namespace firn::toml_text
