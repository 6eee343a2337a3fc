// Limits on the nesting and the number of tables of TOML text, checked before it is parsed: the
// parser recurses by depth, and so does all that walks its tree.
#pragma once

#include <string>
#include <string_view>

namespace firn {

// Throws InputError `SOURCE:LINE: TOML: ...` for text beyond the limits of input_limits.h. Linear
// in the length of the text. Text that is no TOML is left to the parser.
void check_toml_limits(std::string_view text, const std::string& source);

}  // namespace firn
