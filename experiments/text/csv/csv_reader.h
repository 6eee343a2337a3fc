// Reads CSV files (RFC 4180). The first row determines the separator of all fields: a semicolon or
// a tab if it has one outside of quotes, else a comma. With semicolons and tabs, numbers may have a
// decimal comma. Lines that begin with # are comments.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/text/units.h"

namespace firn {

struct CsvRow {
  unsigned line = 0;     // last line of the row in the file, from 1
  char separator = ',';  // between the fields
  std::vector<std::string> fields;
};
// Throws InputError `FILE:LINE: ...` for a file that cannot be read or is not CSV.
std::vector<CsvRow> read_csv_rows(const std::string& file);

// Name and unit of a heading "force [N]" or "force (N)". Without brackets the unit is empty.
struct CsvHeading {
  std::string name, unit;
};
CsvHeading csv_heading(const std::string& field);

// Reads a file with a header row, which is row 0 of the result. All rows have as many fields as the
// header, not counting empty fields at the end. Throws InputError, also for a column with decimal
// points and decimal commas.
std::vector<CsvRow> read_csv_table(const std::string& file);

struct CsvColumn {
  std::string name;
  std::size_t index = 0;
  double unit = 1;  // factor from its numbers to SI
};
// The column with this name. If `dimension` is given, the heading must have a unit of it; a number
// without dimension needs no unit. Throws InputError.
CsvColumn find_csv_column(const std::string& file, const CsvRow& header, const std::string& name,
                          const std::optional<Dimension>& dimension);
// The number of the column in a row, SI. Throws InputError unless it is a finite number.
double csv_number(const std::string& file, const CsvRow& row, const CsvColumn& column);

}  // namespace firn
