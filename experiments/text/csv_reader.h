// Rows of a CSV file (RFC 4180). The first row decides what separates the fields: a semicolon or a
// tab where it has one outside of quotes, else a comma. Between semicolons and tabs, numbers may
// have a decimal comma. Lines that begin with # are remarks.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/text/units.h"

namespace firn {

struct CsvRow {
  unsigned line = 0;     // of the file, on which it ends
  char separator = ',';  // of its fields
  std::vector<std::string> fields;
};
// Throws InputError `FILE:LINE: ...` for a file that cannot be read or is no CSV.
std::vector<CsvRow> read_csv_rows(const std::string& file);

// "way [mm]" or "way (mm)"; without brackets, no unit.
struct CsvHeading {
  std::string name, unit;
};
CsvHeading csv_heading(const std::string& field);

// A file with a header: its rows are all as long as that, but for empty fields at the end. Throws
// InputError, also where one column has numbers with a point and numbers with a decimal comma.
std::vector<CsvRow> read_csv_table(const std::string& file);

struct CsvColumn {
  std::string name;
  std::size_t index = 0;
  double unit = 1;  // of its numbers, SI
};
// The column of this name; its heading must have a unit of the dimension, if one is given. A plain
// number needs none.
// Throws InputError.
CsvColumn find_csv_column(const std::string& file, const CsvRow& header, const std::string& name,
                          const std::optional<Dimension>& dimension);
// Its number in a row, SI. Throws InputError for anything but a finite number.
double csv_number(const std::string& file, const CsvRow& row, const CsvColumn& column);

}  // namespace firn
