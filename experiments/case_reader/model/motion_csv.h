// Ways of a motion over time from a CSV file: what a data logger or a spreadsheet writes.
#pragma once

#include <string>
#include <vector>

#include "experiments/text/units.h"

namespace firn {

struct MotionCsv {
  std::vector<double> times, ways;  // s; m or rad
  std::vector<unsigned> lines;      // of the file, for each row
};

// Reads two columns of a CSV file (RFC 4180; between commas or, if the header has no comma,
// semicolons; lines that begin with # are comments). The first line names each column and its
// unit: `time [s],way [mm]`. Other columns are left alone.
// Throws InputError `FILE:LINE: COLUMN: what is wrong; what is expected` for a file that is
// missing, a column that is not there or has a unit of another kind, a row with more or fewer
// fields than the header, and a field of the two columns that is no finite number.
MotionCsv read_motion_csv(const std::string& file, const std::string& time_column,
                          const std::string& way_column, const Dimension& way);

}  // namespace firn
