// Tables for spreadsheets: one line of text a row, fields between commas (RFC 4180). Text of the
// user stands in a field as encode::csv_field() returns it.
#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <span>
#include <string>

#include "experiments/system/output_file.h"

namespace firn {

inline void append(std::string& line, std::span<const double> values) {
  for (double value : values) line += fmt::format(",{}", value);
}

// DIRECTORY/NAME of an output; the directory is made where it is missing. Throws InputError when it
// cannot be made.
inline std::string output_path(const std::string& directory, const std::string& name) {
  make_output_folder(directory);
  return (std::filesystem::path(directory) / name).string();
}

// A file of lines, there as a whole after close(). Throws as OutputFile.
class CsvFile {
 public:
  CsvFile(const std::string& directory, const std::string& name)
      : stream_(output_path(directory, name)) {}
  void line(const std::string& text) { stream_ << text << '\n'; }
  void close() { stream_.commit(); }

 private:
  OutputFile stream_;
};

}  // namespace firn
