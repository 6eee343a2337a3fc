// Parsing of JSON within limits. json_fields.h reads the values.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace firn {

// Throws InputError `SOURCE:LINE: JSON: ...` for text that is not JSON, has a key twice, or exceeds
// the limits of input_limits.h.
nlohmann::ordered_json parse_json(std::string_view text, const std::string& source);

// The document in a file. Throws also for one that cannot be read or is longer than input_limits.h
// says. `expected`: for the message.
nlohmann::ordered_json read_json_file(const std::string& file, const std::string& expected);

}  // namespace firn
