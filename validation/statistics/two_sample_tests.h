// Tests of whether an experiment's values or counts come from the same distribution as those of
// the runs of a simulation. Pure functions; equal input gives equal bits.
#pragma once

#include <vector>

#include "validation/statistics/distributions.h"

namespace firn {

// Values of each run.
using ValuesByRun = std::vector<std::vector<double>>;

struct SampleTest {
  double distance = 0;  // Smirnov's, or of Kaplan and Meier's shares
  double area = 0;      // between the cumulative distributions; NaN of open times
  double distance_p = 1;
  double area_p = 1;  // of open times: of the difference of log-rank scores
  double p = 1;       // of both together: used for the verdict
  // Smallest distance that chance reaches in at most 5 % of all cases; above 1: none does. Of
  // dependent values, twice the smallest significant difference of mean ranks.
  double critical = 2;
  bool dependent = false;  // values of one run are correlated: runs are compared
};

// `a` and `b` exchanged at random: Smirnov's distance and the area between the cumulative
// distributions, each with its probability; `p` is that of the smaller of the two. Exact for up to
// 20000 ways to split the values, else by 1999 random ones. Neither may be empty.
SampleTest exchange_test(const std::vector<double>& a, const std::vector<double>& b);

// The same for the values of several runs. Where values of one run are correlated (one-way analysis
// of variance of their ranks, p < 0.25), exchange of single values is no valid test. Then mean and
// spread of the experiment's ranks are compared with those of runs, by the scatter from run to run;
// the experiment counts as one run.
SampleTest compare_samples(const ValuesByRun& runs, const std::vector<double>& measured);

// The same for right-censored times. Both samples are cut at the earlier censoring time. Compared
// are the fractions that have passed and the log-rank scores.
SampleTest compare_open_times(const std::vector<CensoredTimes>& runs,
                              const CensoredTimes& measured);

struct ShareTest {
  double distance = 0;    // share that would have to be exchanged
  double p = 1;           // of such a distance or a larger one
  double critical = 2;    // as above
  double dispersion = 1;  // variance of counts over a multinomial's, from run to run; 1 or more
};
// Counts by class of each run and of the experiment. Scatter from run to run beyond a multinomial's
// (chi-square test, p < 0.25) counts; scatter below it does not. Neither may be without counts.
ShareTest compare_shares(const std::vector<std::vector<double>>& runs,
                         const std::vector<double>& measured);

}  // namespace firn
