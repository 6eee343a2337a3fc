// Checks the nesting depth and the number of tables of TOML text before it is parsed. The parser
// and all users of its tree recurse over the depth.
#pragma once

#include <string>
#include <string_view>

namespace firn {

// Throws InputError `SOURCE:LINE: TOML: ...` for text beyond the limits of input_limits.h. Linear
// in the length of the text. Does not check the syntax.
void check_toml_limits(std::string_view text, const std::string& source);

}  // namespace firn
