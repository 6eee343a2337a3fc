// Values recorded row by row: [rows, width].
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

namespace firn {

// One column.
inline std::vector<double> row_column(const std::vector<double>& rows, std::size_t width,
                                      std::size_t column) {
  std::vector<double> values;
  for (std::size_t i = column; i < rows.size(); i += width) values.push_back(rows[i]);
  return values;
}

// Rows of three as the lengths of vectors.
inline std::vector<double> row_lengths(const std::vector<double>& rows) {
  std::vector<double> lengths;
  for (std::size_t i = 0; i + 2 < rows.size(); i += 3)
    lengths.push_back(std::hypot(rows[i], rows[i + 1], rows[i + 2]));
  return lengths;
}

// Mean rates of change over the intervals that the times end; 0 for the first time, and where time
// does not advance.
inline std::vector<double> rates_of_change(const std::vector<double>& times,
                                           const std::vector<double>& values) {
  std::vector<double> rates(values.size(), 0);
  for (std::size_t i = 1; i < values.size(); ++i)
    if (times[i] > times[i - 1]) rates[i] = (values[i] - values[i - 1]) / (times[i] - times[i - 1]);
  return rates;
}

}  // namespace firn
