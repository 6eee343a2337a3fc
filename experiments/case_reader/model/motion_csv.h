// Prescribed positions over time from a CSV file of a data logger or a spreadsheet.
#pragma once

#include <string>
#include <vector>

#include "experiments/text/units.h"

namespace firn {

struct MotionCsv {
  std::vector<double> times, positions;  // s; m or rad
  std::vector<unsigned> lines;           // [rows] line in the file
};

// Reads two columns of a CSV file (RFC 4180; between commas or, if the header has no comma,
// semicolons; lines that begin with # are comments). The first line names each column and its unit:
// `time [s],position [mm]`. Other columns are ignored.
// `position`: dimension of the position, a length or an angle.
// Throws InputError `FILE:LINE: COLUMN: FAULT; EXPECTATION` for a missing file, a column that is
// missing or has a unit of another dimension, a row with more or fewer fields than the header, and
// a field of the two columns that is not a finite number.
MotionCsv read_motion_csv(const std::string& file, const std::string& time_column,
                          const std::string& position_column, const Dimension& position);

}  // namespace firn
