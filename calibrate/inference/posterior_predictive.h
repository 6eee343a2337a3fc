// Posterior predictive distributions of the targets: Gelman and others, Bayesian Data Analysis,
// section 6.3.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "calibrate/inference/posterior.h"

namespace firn {

// Of the median, the central 68 % interval and the central 95 % interval, ascending.
constexpr std::array<double, 5> predictive_probabilities = {0.025, 0.16, 0.5, 0.84, 0.975};

// A distribution of one response, in its unit.
struct PredictiveDistribution {
  std::array<double, 5> quantiles{};  // at `predictive_probabilities`
  // Histogram from the 0.1 % quantile to the 99.9 % quantile in bins of equal width: edges
  // [bins + 1], strictly ascending, and the probability of each bin [bins]. The tails beyond it are
  // left out.
  std::vector<double> edges, probability;
};

struct PosteriorPredictive {
  PredictiveDistribution mean_response;  // mean of the surrogate over the posterior samples
  // Of one run: for each sample a normal distribution about the mean of the surrogate with the
  // variance of the surrogate and that of a run between seeds.
  PredictiveDistribution single_run;
};

// The mixture of the normal distributions with these means and standard deviations (>= 0; 0: all of
// its weight is at the mean), [samples] each, of at least one sample. The weights add up to 1.
// Nothing where a value is not finite.
std::optional<PredictiveDistribution> normal_mixture(const std::vector<double>& means,
                                                     const std::vector<double>& deviations,
                                                     const std::vector<double>& weights);

// Of a target by its response model. Nothing where the surrogate predicts no finite values.
// Deterministic.
std::optional<PosteriorPredictive> posterior_predictive(const ResponseModel& model,
                                                        const Posterior& posterior);

}  // namespace firn
