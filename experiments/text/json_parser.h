// Parsing of JSON within limits. json_fields.h reads the values.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace firn {

// Throws InputError `SOURCE:LINE: JSON: ...` for text that is not JSON, has a key twice, or exceeds
// the limits of input_limits.h.
nlohmann::ordered_json parse_json(std::string_view text, const std::string& source);

}  // namespace firn
