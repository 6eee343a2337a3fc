// Names of responses that have changed. Earlier names are read for one version, with a warning.
// Identities are formed from the first names, as those of TOML files are (toml_aliases.h).
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace firn {

// A name that begins with an underscore follows that of a sensor or motion frame.
struct RenamedResponse {
  std::string_view old_name, name;
};
std::span<const RenamedResponse> renamed_responses();

// The current or the first name of a response. `text` may be an operand (response_expression.h),
// such as "max NAME" or "NAME[2]". Names that have not changed stay as they are.
std::string current_response_name(std::string_view text);
std::string first_response_name(std::string_view text);

}  // namespace firn
