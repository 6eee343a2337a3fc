// Parsing of JSON within limits, and lines of its values. json_fields.h reads the values.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace firn {

// Throws InputError `SOURCE:LINE: JSON: ...` for text that is not JSON, has a key twice, or exceeds
// the limits of input_limits.h.
nlohmann::ordered_json parse_json(std::string_view text, const std::string& source);

// A file as it was read. Messages about the document take lines from its text.
struct JsonFile {
  std::string file, text;
  nlohmann::ordered_json document;
};

// Throws also for a file that cannot be read or is longer than input_limits.h says. `expected`: for
// the message.
JsonFile read_json_file(const std::string& file, const std::string& expected);

// "SOURCE:LINE" of the value at `path` in a text that parse_json() has accepted. `path` holds keys
// of objects in current names (json_aliases.h) and indices of lists. If the text lacks the value,
// the line is that of the innermost object, list or value on the path that it has. "SOURCE" for an
// empty text.
std::string json_place(const std::string& source, std::string_view text,
                       const std::vector<std::string>& path);

}  // namespace firn
