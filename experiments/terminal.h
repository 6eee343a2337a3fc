// What people read on a terminal: no text of a file or of an argument can hold a control sequence.
#pragma once

#include <fmt/format.h>

#include <cstdio>

#include "experiments/text_encoding.h"

namespace firn {

// Writes to a stream of the program. An error of standard output is kept for
// finish_standard_output(), so that the work is completed first.
void print(std::FILE* file, std::string_view text);

// fmt::print() of encode::terminal_lines().
template <class... Arguments>
void print_lines(std::FILE* file, fmt::format_string<Arguments...> format,
                 Arguments&&... arguments) {
  print(file, encode::terminal_lines(fmt::format(format, std::forward<Arguments>(arguments)...)));
}

// Writes what is buffered. Throws WriteError when any part of standard output was lost.
void finish_standard_output();

// Keeps the numbers of standard input, output and error from becoming those of files where the
// caller has closed them. Writes to them then fail.
void occupy_standard_streams();

}  // namespace firn
