// What people read on a terminal: no text of a file or of an argument can hold a control sequence.
#pragma once

#include <fmt/format.h>

#include <cstdio>

#include "experiments/system/text_encoding.h"

namespace firn {

// Writes to a stream of the program. An error of standard output is kept for
// finish_standard_output(), so that the work is completed first. Standard output is written out
// before anything goes to standard error: where both lead to one file, it has whole lines in order.
void print(std::FILE* file, std::string_view text);

// Columns of the terminal at standard error, less one so that a full line does not wrap; 79 when
// they are not known.
std::size_t terminal_columns();

// The text, or as much of it as fits into so many columns, with "…" as its last character. One line
// of printable UTF-8; characters of double width count as two.
std::string fit_columns(std::string_view text, std::size_t columns);

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
