// Writes CSV files (RFC 4180): one line per row, fields separated by commas. Fields with text of
// the user must be encoded by encode::csv_field().
#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <span>
#include <string>

#include "experiments/system/output_file.h"

namespace firn {

// Appends ",VALUE" for each value, with the fewest digits that read back to the same bits.
inline void append(std::string& line, std::span<const double> values) {
  for (double value : values) line += fmt::format(",{}", value);
}

// Path DIRECTORY/NAME of an output. Creates the directory if it is missing. Throws as
// make_output_folder().
inline std::string output_path(const std::string& directory, const std::string& name) {
  make_output_folder(directory);
  return (std::filesystem::path(directory) / name).string();
}

// A file of lines, which exists after close(). Throws as OutputFile.
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
