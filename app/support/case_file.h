// Case files by their names.
#pragma once

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string>

namespace firn {

// Whether a file name has the extension of a case, .toml in upper or lower case.
inline bool is_case_file(const std::string& file) {
  std::string extension = std::filesystem::path(file).extension().string();
  std::ranges::transform(extension, extension.begin(), [](unsigned char letter) {
    return static_cast<char>(std::tolower(letter));
  });
  return extension == ".toml";
}

}  // namespace firn
