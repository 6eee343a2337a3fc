// Tables for spreadsheets: one line of text a row, fields between commas (RFC 4180). Text of the
// user stands in a field as encode::csv_field() returns it.
#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <span>
#include <string>

#include "solver/types.h"

namespace firn {

inline void append(std::string& line, std::span<const double> values) {
  for (double value : values) line += fmt::format(",{}", value);
}

// A file of lines; says so when the disk is full.
class CsvFile {
 public:
  CsvFile(const std::string& directory, const std::string& name)
      : path_((std::filesystem::path(directory) / name).string()) {
    std::error_code error;
    std::filesystem::create_directories(directory, error);
    stream_.open(path_);
    if (!stream_) throw InputError(path_ + ": cannot be written");
  }
  void line(const std::string& text) { stream_ << text << '\n'; }
  void close() {
    stream_.close();
    if (!stream_) throw InputError(path_ + ": cannot be written");
  }

 private:
  std::string path_;
  std::ofstream stream_;
};

}  // namespace firn
