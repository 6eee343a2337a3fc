#pragma once

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <ios>
#include <iterator>
#include <string>
#include <system_error>

namespace firn::test {

// All bytes of a file, unchanged. Throws std::ios_base::failure for a file that cannot be read, so
// that a test which reads the wrong file fails. A file that may be absent:
// read_own_file() (experiments/system/input_file.h).
inline std::string read_text(const std::filesystem::path& file) {
  errno = 0;
  std::ifstream in(file, std::ios::binary);
  if (!in)
    throw std::ios_base::failure("cannot open " + file.string(),
                                 std::error_code(errno, std::generic_category()));
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace firn::test
