// Predicted responses against closed forms, and how often their intervals hold what comes true.
#include "calibrate/inference/posterior_predictive.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "experiments/analysis/sample_statistics.h"
#include "tests/support/fake_experiment.h"

namespace firn {
namespace {

using Eigen::VectorXd;

// At predictive_probabilities, of the standard normal distribution.
constexpr std::array<double, 5> normal_quantiles = {-1.959964, -0.994458, 0, 0.994458, 1.959964};

TEST(NormalMixture, OfOneMember) {
  const auto d = normal_mixture({2}, {0.5}, {1});
  ASSERT_TRUE(d);
  for (std::size_t i = 0; i < 5; ++i)
    EXPECT_NEAR(d->quantiles[i], 2 + 0.5 * normal_quantiles[i], 1e-6);
  ASSERT_EQ(d->edges.size(), d->probability.size() + 1);
  for (std::size_t i = 0; i < d->probability.size(); ++i) {
    const auto below = [&](double x) { return 0.5 * std::erfc((2 - x) / 0.5 / std::sqrt(2.0)); };
    EXPECT_LT(d->edges[i], d->edges[i + 1]);
    EXPECT_NEAR(d->probability[i], below(d->edges[i + 1]) - below(d->edges[i]), 1e-12);
  }
  EXPECT_NEAR(std::accumulate(d->probability.begin(), d->probability.end(), 0.0), 0.998, 1e-9);
}

TEST(NormalMixture, OfMembersThatAreNumbersHasTheirWeightedQuantiles) {
  std::vector<double> values, weights;
  std::mt19937_64 random(3);
  for (int i = 0; i < 1000; ++i) {
    values.push_back(normal_deviate(random));
    weights.push_back(i % 3 == 0 ? 5.0 : 1.0);
  }
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  for (double& w : weights) w /= sum;
  const auto d = normal_mixture(values, std::vector<double>(1000, 0.0), weights);
  ASSERT_TRUE(d);
  for (std::size_t i = 0; i < 5; ++i)
    EXPECT_NEAR(d->quantiles[i], weighted_quantile(values, weights, predictive_probabilities[i]),
                1e-9);
  EXPECT_NEAR(std::accumulate(d->probability.begin(), d->probability.end(), 0.0), 0.998, 0.006);
}

TEST(NormalMixture, OfWhatDoesNotVaryHasBins) {
  for (const double value : {0.0, -40.0, 1e90}) {
    const auto d = normal_mixture({value, value}, {0, 0}, {0.5, 0.5});
    ASSERT_TRUE(d);
    for (const double q : d->quantiles) EXPECT_EQ(q, value);
    for (std::size_t i = 0; i < d->probability.size(); ++i)
      EXPECT_LT(d->edges[i], d->edges[i + 1]) << value;
    EXPECT_NEAR(std::accumulate(d->probability.begin(), d->probability.end(), 0.0), 1, 1e-12);
  }
}

TEST(NormalMixture, OfWhatIsNotFiniteIsNothing) {
  EXPECT_FALSE(normal_mixture({1, std::nan("")}, {0, 0}, {0.5, 0.5}));
  EXPECT_FALSE(normal_mixture({1, 2}, {0, INFINITY}, {0.5, 0.5}));
  EXPECT_FALSE(normal_mixture({1e308, -1e308}, {0, 0}, {0.5, 0.5}));
}

// One parameter p on [0, 1] and the response 10 p, whose runs scatter by `noise(p)`.
struct LinearResponse {
  static double mean(double p) { return 10 * p; }

  explicit LinearResponse(const std::function<double(double)>& noise) {
    constexpr int places = 9, seeds = 14;
    Parameter parameter;
    parameter.name = "p";
    parameter.max = 1;
    study.parameters = {parameter};
    study.targets.push_back({{0, "y", "y"}, 5, 1, "mm", "", 0});
    study.experiments.push_back({"", "", {}, {true}});
    std::vector<Point> points;
    std::mt19937_64 random(11);
    for (int i = 0; i < places; ++i) {
      Point point;
      point.u = VectorXd::Constant(1, i / (places - 1.0));
      point.results.resize(1);
      for (int k = 0; k < seeds; ++k)
        point.results[0].push_back(finished(
            {scalar("y", mean(point.u[0]) + noise(point.u[0]) * normal_deviate(random), "mm")}));
      points.push_back(point);
    }
    models = fit_response_models(study, points);
  }

  PosteriorPredictive predict(double measured, double uncertainty) {
    study.targets[0].value = measured;
    study.targets[0].uncertainty = uncertainty;
    const NegativeLogPosterior misfit(study, *models);
    return posterior_predictive(models->targets[0], sample_posterior(study, misfit)).value();
  }

  Study study;
  std::optional<ResponseModels> models;
};

// With a flat prior, the mean response is as the measurement says, and a run has the variances of
// measurement and noise together.
TEST(PosteriorPredictive, OfALinearResponseInClosedForm) {
  LinearResponse linear([](double) { return 0.8; });
  const PosteriorPredictive p = linear.predict(4, 0.5);
  const ResponseModel& model = linear.models->targets[0];
  EXPECT_NEAR(std::sqrt(model.run_variance(VectorXd::Constant(1, 0.5), 5)), 0.8, 0.1);
  const double surrogate = model.surrogate.best.predict(VectorXd::Constant(1, 0.4)).variance;
  EXPECT_LT(surrogate, 0.03);
  const double mean = std::sqrt(0.25 + surrogate),
               run = std::sqrt(0.25 + 2 * surrogate +
                               model.run_variance(VectorXd::Constant(1, 0.4), 4));
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(p.mean_response.quantiles[i], 4 + mean * normal_quantiles[i], 0.12 * mean) << i;
    EXPECT_NEAR(p.single_run.quantiles[i], 4 + run * normal_quantiles[i], 0.06 * run) << i;
  }
}

// Truths from the prior, measured and run once more: the intervals hold as many as they say.
TEST(PosteriorPredictive, IntervalsCoverWhatTheySay) {
  constexpr double noise = 0.8, uncertainty = 0.5;
  constexpr int studies = 100;
  LinearResponse linear([](double) { return noise; });
  std::mt19937_64 random(5);
  int runs_95 = 0, runs_68 = 0, means_95 = 0;
  for (int i = 0; i < studies; ++i) {
    const double truth = LinearResponse::mean((i + 0.5) / studies);
    const PosteriorPredictive p =
        linear.predict(truth + uncertainty * normal_deviate(random), uncertainty);
    const double run = truth + noise * normal_deviate(random);
    const auto within = [](const PredictiveDistribution& d, double y, std::size_t low) {
      return d.quantiles[low] <= y && y <= d.quantiles[4 - low];
    };
    runs_95 += within(p.single_run, run, 0);
    runs_68 += within(p.single_run, run, 1);
    means_95 += within(p.mean_response, truth, 0);
  }
  RecordProperty("runs_95", runs_95);
  RecordProperty("runs_68", runs_68);
  RecordProperty("means_95", means_95);
  // Two and a half standard deviations of the binomial distribution.
  EXPECT_NEAR(runs_95 / double(studies), 0.95, 0.055);
  EXPECT_NEAR(runs_68 / double(studies), 0.68, 0.12);
  EXPECT_NEAR(means_95 / double(studies), 0.95, 0.055);
}

TEST(PosteriorPredictive, NoiseOfARunIsThatOfItsPlace) {
  LinearResponse linear([](double p) { return p > 0.5 ? 2.0 : 0.1; });
  const ResponseModel& model = linear.models->targets[0];
  ASSERT_FALSE(model.local_noise.uniform());
  EXPECT_NEAR(std::sqrt(model.run_variance(VectorXd::Constant(1, 0.95), 9.5)), 2, 0.6);
  EXPECT_LT(std::sqrt(model.run_variance(VectorXd::Constant(1, 0.05), 0.5)), 0.7);
  const PosteriorPredictive rough = linear.predict(9, 0.1), quiet = linear.predict(1, 0.1);
  const auto width = [](const PredictiveDistribution& d) {
    return d.quantiles[4] - d.quantiles[0];
  };
  EXPECT_GT(width(rough.single_run), 3 * width(quiet.single_run));
}

}  // namespace
}  // namespace firn
