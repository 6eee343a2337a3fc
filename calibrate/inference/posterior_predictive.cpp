#include "calibrate/inference/posterior_predictive.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace firn {
namespace {

constexpr int predictive_bins = 30;
constexpr double tail = 0.001;  // on each side of a histogram
constexpr int bisections = 50;

// A mixture as its cumulative distribution function and the range that holds all of it.
struct Mixture {
  const std::vector<double>&means, &deviations, &weights;

  double cumulative(double x) const {
    double sum = 0;
    for (std::size_t s = 0; s < means.size(); ++s)
      sum += weights[s] * (deviations[s] > 0
                               ? 0.5 * std::erfc((means[s] - x) / (deviations[s] * M_SQRT2))
                               : static_cast<double>(x >= means[s]));
    return sum;
  }

  double quantile(double probability, double low, double high) const {
    for (int i = 0; i < bisections && low < high; ++i) {
      const double middle = low + 0.5 * (high - low);
      (cumulative(middle) < probability ? low : high) = middle;
    }
    return high;
  }
};

}  // namespace

std::optional<PredictiveDistribution> normal_mixture(const std::vector<double>& means,
                                                     const std::vector<double>& deviations,
                                                     const std::vector<double>& weights) {
  constexpr double reach = 9;  // standard deviations
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (std::size_t s = 0; s < means.size(); ++s) {
    if (!std::isfinite(means[s]) || !std::isfinite(deviations[s])) return std::nullopt;
    low = std::min(low, means[s] - reach * deviations[s]);
    high = std::max(high, means[s] + reach * deviations[s]);
  }
  if (!std::isfinite(high - low)) return std::nullopt;
  const Mixture mixture{means, deviations, weights};
  PredictiveDistribution d;
  for (std::size_t i = 0; i < d.quantiles.size(); ++i)
    d.quantiles[i] = mixture.quantile(predictive_probabilities[i], low, high);
  double first = mixture.quantile(tail, low, high), last = mixture.quantile(1 - tail, low, high);
  // A response that no parameter changes: bins that numbers can still distinguish.
  const double least = std::max(1e-9 * std::max(std::abs(first), std::abs(last)), 1e-200);
  if (last - first < least) {
    first -= least;
    last += least;
  }
  for (int i = 0; i <= predictive_bins; ++i)
    d.edges.push_back(first + (last - first) * i / predictive_bins);
  double below = mixture.cumulative(first);
  for (int i = 1; i <= predictive_bins; ++i) {
    const double up_to = mixture.cumulative(d.edges[static_cast<std::size_t>(i)]);
    d.probability.push_back(std::max(0.0, up_to - below));
    below = up_to;
  }
  return d;
}

std::optional<PosteriorPredictive> posterior_predictive(const ResponseModel& model,
                                                        const Posterior& posterior) {
  const std::size_t n = posterior.u.size();
  std::vector<double> means(n), deviations(n);
  for (std::size_t s = 0; s < n; ++s) {
    const Prediction p = model.surrogate.best.predict(posterior.u[s]);
    means[s] = p.mean;
    deviations[s] = std::sqrt(p.variance + model.run_variance(posterior.u[s], p.mean));
  }
  const auto mean = normal_mixture(means, std::vector<double>(n, 0.0), posterior.weight);
  const auto run = normal_mixture(means, deviations, posterior.weight);
  if (!mean || !run) return std::nullopt;
  return PosteriorPredictive{*mean, *run};
}

}  // namespace firn
