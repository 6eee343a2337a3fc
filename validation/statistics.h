// What samples tell: intervals, distances between distributions, and exact tests. Pure functions.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "experiments/material_record.h"
#include "experiments/measurement.h"

namespace firn {

struct SampleFacts {
  int count = 0;
  double mean = 0;
  double deviation = 0;  // standard, of one value; NaN below two
  double error() const;  // standard, of the mean; NaN below two
};
SampleFacts facts_of(const std::vector<double>& values);

// Clopper and Pearson (1934): covers the probability in at least `confidence` of all cases.
Interval binomial_interval(int successes, int trials, double confidence = 0.95);

// Half-width of a two-sided interval of Student's distribution, in standard errors.
double student_factor(double degrees_of_freedom, double confidence = 0.95);

// A sample's cumulative distribution, or bounds on it: steps at x (ascending), and from x[i] on it
// lies between lower[i] and upper[i]; 0 before x[0], 1 from the last on.
struct DistributionBand {
  std::vector<double> x, lower, upper;
  Interval at(double value) const;
};
DistributionBand empirical_distribution(std::vector<double> values);
// All that n values with this smallest, largest and mean value can be: tight for every x. n >= 2;
// throws InputError when no such values exist.
DistributionBand distribution_from_summary(int n, double minimum, double maximum, double mean);
// The repeats' distribution, as far as a measurement tells it; nothing where it gives no values and
// no range.
std::optional<DistributionBand> distribution_of(const Measurement& measurement);

// Half-width of a band around an empirical distribution of n values that holds the true one at
// every x with this confidence, whatever it is (Dvoretzky, Kiefer and Wolfowitz; Massart 1990).
double distribution_band_width(int n, double confidence = 0.95);

// Area between two cumulative distributions, in the unit of x (Ferson et al. 2008; for two samples,
// the Wasserstein distance of order one). An interval where one is only bounded.
Interval area_metric(const std::vector<double>& sample, const DistributionBand& other);
double wasserstein_distance(const std::vector<double>& a, const std::vector<double>& b);

// Largest distance between two samples' cumulative distributions (Smirnov).
double smirnov_distance(const std::vector<double>& a, const std::vector<double>& b);
// Probability of that distance or a larger one when both come from one distribution: exact for any
// sizes, ties included, given the pooled values.
double smirnov_p_value(const std::vector<double>& a, const std::vector<double>& b);

// Probability of a statistic as large as this one or larger when the two samples could have been
// exchanged at random: exact where there are at most 20000 ways to split them, else by `draws` of
// them (the observed one counted in, so that it is never zero). Depends on nothing but its input.
double permutation_p_value(
    const std::vector<double>& a, const std::vector<double>& b,
    const std::function<double(const std::vector<double>&, const std::vector<double>&)>& statistic,
    int draws = 9999);

// Times until something has happened, and times after which it had not yet: of those still inside
// when the watch ended.
struct CensoredTimes {
  std::vector<double> passed, inside;
};
// Share that has passed by x, steps at x ascending: one less Kaplan and Meier's (1958) share that
// is still inside. It does not reach 1 when the last ones were not seen to pass.
struct PassedShare {
  std::vector<double> x, share;
  std::vector<double> error;  // one standard deviation (Greenwood 1926)
};
PassedShare kaplan_meier(const CensoredTimes& times);
// Largest distance of two of them, as far as both reach.
double passed_distance(const PassedShare& a, const PassedShare& b);
// Probability of such a distance or a larger one when the two could have been exchanged at random.
double passed_p_value(const CensoredTimes& a, const CensoredTimes& b, int draws = 9999);

// Counts by class of two collections: half the sum of the differences of their shares, 0 ... 1.
double share_distance(const std::vector<double>& a, const std::vector<double>& b);
// Probability of such a distance or a larger one when all counted things were dealt out at random.
double share_p_value(const std::vector<double>& a, const std::vector<double>& b, int draws = 9999);

}  // namespace firn
