// Statistics of samples: intervals, distances between distributions, and exact tests. Pure
// functions.
#pragma once

#include <optional>
#include <vector>

#include "experiments/analysis/sample_statistics.h"
#include "experiments/measurements/measurement.h"

namespace firn {

// A sample's cumulative distribution, or bounds on it: steps at x (ascending), and from x[i] on it
// lies between lower[i] and upper[i]; 0 before x[0], 1 from the last on.
struct DistributionBand {
  std::vector<double> x, lower, upper;
  Interval at(double value) const;
};
DistributionBand empirical_distribution(std::vector<double> values);
// Bounds of the distribution of n values with this smallest, largest and mean value; tight for
// every x. n >= 2; throws InputError when no such values exist.
DistributionBand distribution_from_summary(int n, double minimum, double maximum, double mean);
// Bounds of the distribution of the repeats of a measurement; none without values and without a
// range.
std::optional<DistributionBand> distribution_of(const Measurement& measurement);

// Half-width of a band around an empirical distribution of n values that holds the true one at
// every x with this confidence, whatever it is (Dvoretzky, Kiefer and Wolfowitz; Massart 1990).
double distribution_band_width(int n, double confidence = 0.95);

// Area between two cumulative distributions, in the unit of x (Ferson et al. 2008).
// An interval where one is only bounded.
Interval area_metric(const std::vector<double>& sample, const DistributionBand& other);

// Right-censored times: times until an event, and observation times without an event.
struct CensoredTimes {
  std::vector<double> passed, inside;
};
// Share that has passed by x, steps at x ascending: one less Kaplan and Meier's (1958) share that
// is still inside. It does not reach 1 when the last ones are censored.
struct EmpiricalCdf {
  std::vector<double> x, share;
  std::vector<double> error;  // one standard deviation (Greenwood 1926)
};
EmpiricalCdf kaplan_meier(const CensoredTimes& times);
// Counts by class of two collections: half the sum of the differences of their shares, 0 ... 1.
double total_variation_distance(const std::vector<double>& a, const std::vector<double>& b);

}  // namespace firn
