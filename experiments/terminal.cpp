#include "experiments/terminal.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <iostream>

#include "experiments/output_file.h"

namespace firn {
namespace {

int first_error = 0;  // errno of standard output

void note_error() {
  if (first_error == 0) first_error = errno == 0 ? EIO : errno;
}

}  // namespace

void print(std::FILE* file, std::string_view text) {
  const bool whole = std::fwrite(text.data(), 1, text.size(), file) == text.size();
  if (!whole && file == stdout) note_error();
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
