// Statistics of samples.
#pragma once

#include <vector>

namespace firn {

// Middle of the values (mean of the two middle ones); of at least one.
double median(std::vector<double> values);

// The smallest value that at least the fraction `share` of all values does not exceed, of values in
// ascending order; `of_none` without values.
double quantile(const std::vector<double>& sorted, double share, double of_none);

// Of at least one value.
double mean(const std::vector<double>& values);

// Of a sample (n - 1); of at least two values.
double standard_deviation(const std::vector<double>& values);

// A variance estimated with few degrees of freedom, widened to that of Student's distribution
// (which has none below three: taken as at three).
double widened(double variance, double degrees_of_freedom);

}  // namespace firn
