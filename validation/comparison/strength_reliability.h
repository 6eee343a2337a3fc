// Loads on particles against their strength: the probability of breakage and its uncertainty.
// Breaking forces are single values or a summary of a few tests.
#pragma once

#include <optional>
#include <vector>

#include "experiments/measurements/measurement.h"
#include "validation/statistics/distributions.h"

namespace firn {

// The probability that a particle breaks under its largest load, averaged over all loads, and that
// at least one of a run's particles does (strengths taken as independent of loads and each other).
struct BreakageProbability {
  Interval each;  // bounds, or an interval of 95 % confidence
  Interval any;
  double each_best = 0, any_best = 0;  // NaN: no best estimate within the bounds
};

// Without an assumption on the distribution: bounds from the tests' order statistics, widened by
// the uncertainty of the population from n tests (distribution_band_width). `runs`: the loads (N)
// of each run's particles. Throws InputError for a measurement without range.
BreakageProbability breakage_distribution_free(const std::vector<std::vector<double>>& runs,
                                               const Measurement& breaking_force);

// Breaking forces taken as Weibull-distributed, shape and scale by the likelihood of the tests
// (their values, or smallest, largest and mean), on a grid with flat priors of their logarithms.
struct WeibullFit {
  std::vector<double> shape, scale, weight;  // posterior on the grid; weights sum to 1
  Interval shape_95;
  double shape_median = 0;
};
WeibullFit fit_weibull(const Measurement& breaking_force);
BreakageProbability breakage_weibull(const std::vector<std::vector<double>>& runs,
                                     const WeibullFit& fit);

}  // namespace firn
