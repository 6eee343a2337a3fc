// Output to the terminal. Control sequences in texts of files and arguments are made visible.
#pragma once

#include <fmt/format.h>

#include <cstdio>

#include "experiments/system/text_encoding.h"

namespace firn {

// Writes to a standard stream. An error of standard output is stored for finish_standard_output(),
// so that the work is completed first. Standard output is flushed before a write to standard error:
// lines stay whole and in order when both go to one file.
void print(std::FILE* file, std::string_view text);

// Columns of the terminal at standard error, less one to avoid a line wrap; 79 if unknown.
std::size_t terminal_columns();

// The text, shortened to `columns` columns with "…" as its last character if it is longer. `text`:
// one line of printable UTF-8. Characters of double width count as two columns.
std::string fit_columns(std::string_view text, std::size_t columns);

// A bar of `width` columns and two brackets, filled for a share from 0 to 1.
std::string progress_bar(double share, int width);

// Lines at the end of standard error, a terminal, that are drawn again and again in one place.
class TerminalLines {
 public:
  TerminalLines() = default;
  TerminalLines(const TerminalLines&) = delete;
  TerminalLines& operator=(const TerminalLines&) = delete;
  ~TerminalLines() { erase(); }
  // Replaces the lines. Each is shortened to the width of the terminal. Control sequences in `text`
  // are made visible.
  void draw(const std::string& text);
  void erase();

 private:
  int drawn_ = 0;
};

// fmt::print() of encode::terminal_lines().
template <class... Arguments>
void print_lines(std::FILE* file, fmt::format_string<Arguments...> format,
                 Arguments&&... arguments) {
  print(file, encode::terminal_lines(fmt::format(format, std::forward<Arguments>(arguments)...)));
}

// Flushes standard output. Throws WriteError when any write to it has failed.
void finish_standard_output();

// Reserves the descriptors 0, 1 and 2 where the caller has closed them, so that no opened file gets
// one of them. Writes to them then fail.
void occupy_standard_streams();

}  // namespace firn
