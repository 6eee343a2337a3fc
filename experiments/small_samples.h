// What few values tell of their scatter.
#pragma once

#include <algorithm>

namespace firn {

// A variance estimated with few degrees of freedom, widened to that of Student's distribution
// (which has none below three: taken as at three).
inline double widened(double variance, double degrees_of_freedom) {
  const double freedom = std::max(degrees_of_freedom, 3.0);
  return variance * freedom / (freedom - 2);
}

}  // namespace firn
