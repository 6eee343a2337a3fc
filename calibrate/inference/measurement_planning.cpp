#include "calibrate/inference/measurement_planning.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace firn {
namespace {

using Eigen::VectorXd;

constexpr std::size_t hypotheses = 1024;  // each is the truth once

// Gauss-Hermite nodes for the scatter of the outcome itself: standard deviations and weights.
constexpr std::array<std::array<double, 2>, 3> scatter = {
    {{0, 2.0 / 3}, {-1.7320508075688772, 1.0 / 6}, {1.7320508075688772, 1.0 / 6}}};

double log_normal_density(double y, double mean, double variance) {
  return -0.5 * ((y - mean) * (y - mean) / variance + std::log(2 * M_PI * variance));
}

// Of the values x with these weights (not normalized).
double weighted_sd(const std::vector<double>& x, const std::vector<double>& weight) {
  double w = 0, mean = 0, squares = 0;
  for (std::size_t s = 0; s < x.size(); ++s) {
    w += weight[s];
    mean += weight[s] * x[s];
  }
  mean /= w;
  for (std::size_t s = 0; s < x.size(); ++s) squares += weight[s] * (x[s] - mean) * (x[s] - mean);
  return std::sqrt(squares / w);
}

// The expected result of a measurement where `model` predicts `p`. The first measurement of the
// same response, of the value `known`, has the same error of the model and the same discrepancy.
// They are taken as known from it, and a second measurement does not average them out.
struct Outcome {
  double mean, variance;
};
Outcome outcome_of(const Prediction& p, const MeasurementValue& a,
                   const std::optional<double>& known) {
  const double own = a.uncertainty * a.uncertainty;
  const double common = p.variance + a.discrepancy * a.discrepancy;
  if (!known) return {p.mean, common + own};
  const double learned = common / (common + own);
  return {p.mean + learned * (*known - p.mean), (1 - learned) * common + own};
}

void judge(const Surrogate& model, const std::vector<VectorXd>& believed, const VectorXd& longest,
           const std::optional<double>& known, MeasurementValue& a) {
  std::vector<double> mean, variance, along;
  for (const VectorXd& u : believed) {
    const Outcome outcome = outcome_of(model.predict(u), a, known);
    mean.push_back(outcome.mean);
    variance.push_back(outcome.variance);
    along.push_back(longest.dot(u));
  }
  const double before = weighted_sd(along, std::vector<double>(along.size(), 1.0));
  double nats = 0, after = 0;
  std::vector<double> likelihood(believed.size());
  for (std::size_t t = 0; t < believed.size(); ++t)
    for (const auto& [z, part] : scatter) {
      const double y = mean[t] + z * std::sqrt(variance[t]);
      double evidence = 0;
      for (std::size_t s = 0; s < believed.size(); ++s) {
        likelihood[s] = std::exp(log_normal_density(y, mean[s], variance[s]));
        evidence += likelihood[s] / static_cast<double>(believed.size());
      }
      const double share = part / static_cast<double>(believed.size());
      nats += share * (log_normal_density(y, mean[t], variance[t]) - std::log(evidence));
      after += share * weighted_sd(along, likelihood);
    }
  a.information = std::max(0.0, nats) / std::log(2.0);
  a.remaining_extent = before > 0 ? after / before : 1;
}

}  // namespace

std::vector<MeasurementValue> rank_measurements(const Study& study, const ResponseModels& models,
                                                const Posterior& posterior) {
  const std::vector<VectorXd> believed = resampled(posterior, hypotheses);
  std::vector<MeasurementValue> all;
  for (std::size_t k = 0; k < study.targets.size(); ++k) {
    const Target& t = study.targets[k];
    all.push_back({t.response, true, t.uncertainty, t.unit, t.effort, 0, 1, t.discrepancy});
    judge(models.targets[k].surrogate.best, believed, posterior.longest, t.value, all.back());
  }
  for (const Observed& o : study.observed) {
    if (o.uncertainty == 0) continue;
    for (const ResponseModel& m : models.observed)
      if (m.response.label == o.response.label) {
        all.push_back({o.response, false, o.uncertainty, o.unit, o.effort, 0, 1, o.discrepancy});
        judge(m.surrogate.best, believed, posterior.longest, {}, all.back());
      }
  }
  const bool efforts =
      std::all_of(all.begin(), all.end(), [](const MeasurementValue& a) { return a.effort > 0; });
  // A better measurement along a determined direction does not shorten the ridge. The measure is
  // the reduction of its length, in halvings.
  const auto worth = [&](const MeasurementValue& a) {
    return -std::log2(a.remaining_extent) / (efforts ? a.effort : 1);
  };
  std::stable_sort(
      all.begin(), all.end(),
      [&](const MeasurementValue& a, const MeasurementValue& b) { return worth(a) > worth(b); });
  return all;
}

}  // namespace firn
