// Fits of straight lines.
#pragma once

#include <span>
#include <vector>

namespace firn {

struct Line {
  double slope = 0;      // dy/dx
  double intercept = 0;  // y at x = 0
};

// Least squares. Requires as many x as y, at least two, and two different x. The slope is 0 if all
// x are equal to the precision of their squares.
Line least_squares_line(std::span<const double> x, std::span<const double> y);
// Robust fit of Theil (1950) and Sen (1968): median of the slopes of all pairs of points, and
// median of the intercepts for that slope. Breakdown point 29 %. Requirements as above.
Line theil_sen_line(std::span<const double> x, std::span<const double> y);

}  // namespace firn
