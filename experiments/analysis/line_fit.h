// Straight lines through measured points.
#pragma once

#include <span>
#include <vector>

namespace firn {

struct Line {
  double slope = 0;      // dy/dx
  double intercept = 0;  // y at x = 0
};

// Both need equally many x and y, at least two, and not all x the same. The first has a slope of 0
// where all x are the same to the precision of their squares.
Line least_squares_line(std::span<const double> x, std::span<const double> y);
// Theil (1950), Sen (1968): the median of the slopes of all pairs, and the median intercept that
// goes with it. Up to 29 % of the points may be anything.
Line theil_sen_line(std::span<const double> x, std::span<const double> y);

}  // namespace firn
