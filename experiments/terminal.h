// What people read on a terminal: no text of a file or of an argument can hold a control sequence.
#pragma once

#include <fmt/format.h>

#include <cstdio>

#include "experiments/text_encoding.h"

namespace firn {

// fmt::print() of encode::terminal_lines().
template <class... Arguments>
void print_lines(std::FILE* file, fmt::format_string<Arguments...> format,
                 Arguments&&... arguments) {
  const std::string text =
      encode::terminal_lines(fmt::format(format, std::forward<Arguments>(arguments)...));
  std::fwrite(text.data(), 1, text.size(), file);
}

}  // namespace firn
