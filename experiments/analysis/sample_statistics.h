// Statistics of samples.
#pragma once

#include <vector>

namespace firn {

struct Interval {
  double low = 0, high = 0;
};

// Interval of the probability of success, 0 to 1 without trials. Clopper and Pearson (1934): covers
// the probability in at least `confidence` of all cases.
Interval binomial_interval(int successes, int trials, double confidence = 0.95);

// Median; mean of the two middle values for an even number. At least one value.
double median(std::vector<double> values);

// Quantile of values in ascending order: the smallest value such that at least the fraction `share`
// of all values does not exceed it. `of_none` without values.
double quantile(const std::vector<double>& sorted, double share, double of_none);

// x such that at least a fraction q of the weight lies at or below it. `weight` sums to 1.
double weighted_quantile(const std::vector<double>& x, const std::vector<double>& weight, double q);

// Mean of at least one value.
double mean(const std::vector<double>& values);

// Sum of the squared differences from `middle`.
double sum_of_squares(const std::vector<double>& values, double middle);

// Sample standard deviation (n - 1) of at least two values.
double standard_deviation(const std::vector<double>& values);

// Half-width of a two-sided interval of Student's distribution with this probability, in standard
// errors.
double student_factor(double degrees_of_freedom, double confidence = 0.95);

struct SampleStatistics {
  int count = 0;
  double mean = 0;       // NaN without values
  double deviation = 0;  // standard, of one value; NaN below two
  double error() const;  // standard, of the mean; NaN below two
};
SampleStatistics sample_statistics(const std::vector<double>& values);

// Last finite value; 0 without one.
double last_finite(const std::vector<double>& values);

// Variance of Student's distribution with this scale: variance * n / (n - 2) for n degrees of
// freedom. Fewer than three degrees of freedom count as three, since the variance is infinite
// below.
double widened_variance(double variance, double degrees_of_freedom);

}  // namespace firn
