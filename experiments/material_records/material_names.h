// Characters of names in material records.
#pragma once

#include <algorithm>
#include <cctype>
#include <string_view>

namespace firn {

// True for a text of at least one character, of ASCII letters, digits and the characters of `also`.
inline bool has_name_characters(std::string_view text, std::string_view also) {
  return !text.empty() && std::ranges::all_of(text, [&](unsigned char c) {
    return (c < 128 && std::isalnum(c)) || also.find(static_cast<char>(c)) != also.npos;
  });
}

}  // namespace firn
