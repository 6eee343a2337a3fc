// Renamed responses. Old names are accepted for one version, with a warning. Hashes and keys of
// runs are computed from the first names, as for TOML files (toml_aliases.h).
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace firn {

// A name that begins with an underscore is a suffix to the name of a sensor or motion frame.
struct RenamedResponse {
  std::string_view old_name, name;
};
std::span<const RenamedResponse> renamed_responses();

// Replaces the name of a response by its current or its first name. `text`: a name or an expression
// with one (response_expression.h), such as "max NAME" or "NAME[2]". Other names are returned
// unchanged.
std::string current_response_name(std::string_view text);
std::string first_response_name(std::string_view text);

}  // namespace firn
