#include "experiments/system/terminal.h"

#include <fcntl.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <iostream>
#include <sstream>

#include "experiments/system/output_file.h"

namespace firn {
namespace {

int first_error = 0;  // errno of standard output

void note_error() {
  if (first_error == 0) first_error = errno == 0 ? EIO : errno;
}

}  // namespace

void print(std::FILE* file, std::string_view text) {
  if (file == stderr && std::fflush(stdout) != 0) note_error();
  const bool whole = std::fwrite(text.data(), 1, text.size(), file) == text.size();
  if (!whole && file == stdout) note_error();
}

std::size_t terminal_columns() {
  winsize size = {};
  const bool known = ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1;
  return known ? size.ws_col - 1u : 79u;
}

std::string fit_columns(std::string_view text, std::size_t columns) {
  std::size_t used = 0, kept = 0;  // columns; bytes that leave room for the ellipsis
  for (std::size_t i = 0; i < text.size();) {
    const auto lead = static_cast<unsigned char>(text[i]);
    const std::size_t bytes = lead < 0x80 ? 1 : lead < 0xE0 ? 2 : lead < 0xF0 ? 3 : 4;
    const bool wide = lead > 0xE1 || (lead == 0xE1 && i + 1 < text.size() &&
                                      static_cast<unsigned char>(text[i + 1]) >= 0x84);
    used += wide ? 2 : 1;
    if (used > columns) return columns == 0 ? "" : std::string(text.substr(0, kept)) + "…";
    i = std::min(i + bytes, text.size());
    if (used < columns) kept = i;
  }
  return std::string(text);
}

std::string progress_bar(double share, int width) {
  const int filled = static_cast<int>(std::clamp(share, 0.0, 1.0) * width);
  return fmt::format("[{:=<{}}{: <{}}]", "", filled, "", width - filled);
}

void TerminalLines::draw(const std::string& text) {
  erase();
  const std::size_t columns = terminal_columns();  // a line that wraps could not be erased
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line); ++drawn_)
    print_lines(stderr, "{}{}", drawn_ > 0 ? "\n" : "", fit_columns(line, columns));
  std::fflush(stderr);
}

void TerminalLines::erase() {
  if (drawn_ == 0) return;
  for (int i = 1; i < drawn_; ++i) print(stderr, "\r\x1b[K\x1b[A");
  print(stderr, "\r\x1b[K");
  drawn_ = 0;
}

void finish_standard_output() {
  if (!std::cout.flush()) note_error();
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) note_error();
  if (first_error != 0) throw WriteError("standard output", first_error);
}

void occupy_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (::fcntl(stream, F_GETFD) < 0) {
      // The lowest number that is free; each mode is the one that the stream is not used in.
      if (::open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY) != stream) return;
    }
}

}  // namespace firn
