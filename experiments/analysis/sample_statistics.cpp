#include "experiments/analysis/sample_statistics.h"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

namespace firn {

Interval binomial_interval(int successes, int trials, double confidence) {
  assert(0 <= successes && successes <= trials);
  if (trials == 0) return {0, 1};
  using Binomial = boost::math::binomial_distribution<double>;
  const double tail = (1 - confidence) / 2;
  return {successes == 0 ? 0 : Binomial::find_lower_bound_on_p(trials, successes, tail),
          successes == trials ? 1 : Binomial::find_upper_bound_on_p(trials, successes, tail)};
}

double median(std::vector<double> values) {
  assert(!values.empty());
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

double quantile(const std::vector<double>& sorted, double share, double of_none) {
  if (sorted.empty()) return of_none;
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(sorted.size())));
  return sorted[std::max<std::size_t>(rank, 1) - 1];
}

double weighted_quantile(const std::vector<double>& x, const std::vector<double>& weight,
                         double q) {
  std::vector<std::pair<double, double>> sorted;
  sorted.reserve(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) sorted.emplace_back(x[i], weight[i]);
  std::sort(sorted.begin(), sorted.end());
  double sum = 0;
  for (const auto& [value, share] : sorted) {
    sum += share;
    if (sum >= q) return value;
  }
  return sorted.back().first;
}

double mean(const std::vector<double>& values) {
  double mean = 0;
  for (const double v : values) mean += v / static_cast<double>(values.size());
  return mean;
}

double sum_of_squares(const std::vector<double>& values, double middle) {
  double sum = 0;
  for (const double v : values) sum += (v - middle) * (v - middle);
  return sum;
}

double standard_deviation(const std::vector<double>& values) {
  return std::sqrt(sum_of_squares(values, mean(values)) / static_cast<double>(values.size() - 1));
}

double student_factor(double degrees_of_freedom, double confidence) {
  return boost::math::quantile(boost::math::students_t(degrees_of_freedom), (1 + confidence) / 2);
}

double SampleStatistics::error() const {
  return count < 2 ? std::numeric_limits<double>::quiet_NaN()
                   : deviation / std::sqrt(static_cast<double>(count));
}

SampleStatistics sample_statistics(const std::vector<double>& values) {
  constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
  SampleStatistics s;
  s.count = static_cast<int>(values.size());
  s.mean = values.empty() ? nothing : mean(values);
  s.deviation = s.count < 2 ? nothing : standard_deviation(values);
  return s;
}

double last_finite(const std::vector<double>& values) {
  for (auto v = values.rbegin(); v != values.rend(); ++v)
    if (std::isfinite(*v)) return *v;
  return 0;
}

double widened_variance(double variance, double degrees_of_freedom) {
  const double freedom = std::max(degrees_of_freedom, 3.0);
  return variance * freedom / (freedom - 2);
}

}  // namespace firn
