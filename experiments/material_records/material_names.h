// What names in material records are made of.
#pragma once

#include <algorithm>
#include <cctype>
#include <string_view>

namespace firn {

// Whether a text is letters, digits and characters of `also`, one at least.
inline bool is_plain_name(std::string_view text, std::string_view also) {
  return !text.empty() && std::ranges::all_of(text, [&](unsigned char c) {
    return (c < 128 && std::isalnum(c)) || also.find(static_cast<char>(c)) != also.npos;
  });
}

}  // namespace firn
