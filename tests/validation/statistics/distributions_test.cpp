#include "validation/statistics/distributions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "experiments/analysis/random_stream.h"
#include "tests/validation/statistics/samples.h"
#include "validation/comparison/strength_reliability.h"

namespace firn {
namespace {

using samples::placebo;
using samples::treated;

TEST(SampleStatistics, AreTheTextbooks) {
  const SampleStatistics f = sample_statistics({1, 2, 3, 4});
  EXPECT_EQ(f.mean, 2.5);
  EXPECT_NEAR(f.deviation, std::sqrt(5.0 / 3), 1e-15);
  EXPECT_NEAR(f.error(), std::sqrt(5.0 / 12), 1e-15);
  EXPECT_TRUE(std::isnan(sample_statistics({1}).deviation));
}

TEST(Summary, HoldsEveryPossibleSampleAndIsTight) {
  const int n = 5;
  std::mt19937_64 bits(5);
  const double low = 2, high = 9, mean = 5;
  const DistributionBand band = distribution_from_summary(n, low, high, mean);
  std::vector<double> least(band.x.size(), 1), most(band.x.size(), 0);
  int samples = 0;
  while (samples < 20000) {
    // The three inner values sum to 14: two at random, the third follows. Extremes often.
    std::vector<double> v = {low, high};
    for (int k = 0; k < 2; ++k) {
      const double r = uniform_half_open(bits);
      v.push_back(r < 0.3 ? low : r < 0.6 ? high : low + (high - low) * uniform_half_open(bits));
    }
    v.push_back(n * mean - v[0] - v[1] - v[2] - v[3]);
    if (v.back() < low || v.back() > high) continue;
    ++samples;
    for (std::size_t i = 0; i + 1 < band.x.size(); ++i) {
      const double x = (band.x[i] + band.x[i + 1]) / 2;
      const double f =
          static_cast<double>(std::ranges::count_if(v, [&](double y) { return y <= x; })) / n;
      EXPECT_LE(band.at(x).low, f + 1e-12);
      EXPECT_GE(band.at(x).high, f - 1e-12);
      least[i] = std::min(least[i], f);
      most[i] = std::max(most[i], f);
    }
  }
  for (std::size_t i = 0; i + 1 < band.x.size(); ++i) {
    EXPECT_NEAR(least[i], band.lower[i], 1e-12) << band.x[i];
    EXPECT_NEAR(most[i], band.upper[i], 1e-12) << band.x[i];
  }
  EXPECT_THROW(distribution_from_summary(7, 1, 2, 2), InputError);  // six at 2, one at 1: less
}

TEST(Summary, OfThreeValuesIsTheSample) {
  const DistributionBand band = distribution_from_summary(3, 1, 4, 2);  // 1, 1, 4
  EXPECT_NEAR(band.at(2).low, 2.0 / 3, 1e-12);
  EXPECT_NEAR(band.at(2).high, 2.0 / 3, 1e-12);
}

TEST(AreaMetric, OfABandIsAnInterval) {
  const DistributionBand exact = empirical_distribution({1, 2, 3});
  EXPECT_NEAR(area_metric({2, 3, 4}, exact).low, 1, 1e-12);
  EXPECT_NEAR(area_metric({2, 3, 4}, exact).high, 1, 1e-12);
  const DistributionBand bounded = distribution_from_summary(4, 0, 10, 5);
  const Interval within = area_metric({0, 5, 5, 10}, bounded);  // one of the samples it can be
  EXPECT_NEAR(within.low, 0, 1e-12);
  EXPECT_GT(within.high, 0);
}

Measurement summary(int n, double minimum, double maximum, double mean) {
  Measurement m;
  m.unit = "N";
  m.value = mean;
  m.repeats = n;
  m.minimum = minimum;
  m.maximum = maximum;
  m.scatter = ScatterKind::range;
  return m;
}

TEST(Damage, WithoutAssumptionIsWhatTheTestsBound) {
  const Measurement m = summary(7, 898.5, 1227.7, 1044);
  const double width = distribution_band_width(7);
  EXPECT_NEAR(width, std::sqrt(std::log(40.0) / 14), 1e-15);
  const BreakageProbability low = breakage_distribution_free({{100, 200}}, m);
  EXPECT_EQ(low.each.low, 0);
  EXPECT_NEAR(low.each.high, width, 1e-12);
  EXPECT_NEAR(low.any.high, 1 - (1 - width) * (1 - width), 1e-12);
  const BreakageProbability high = breakage_distribution_free({{2000}}, m);
  EXPECT_NEAR(high.each.low, 1 - width, 1e-12);
  EXPECT_EQ(high.each.high, 1);
  EXPECT_EQ(breakage_distribution_free({{0, 0}}, m).any.high, 0);
}

TEST(Damage, WeibullIsFoundFromValuesAndFromTheirSummary) {
  std::mt19937_64 bits(6);
  const double shape = 8, scale = 1000;
  std::vector<double> values(60);
  for (double& v : values) v = scale * std::pow(-std::log1p(-uniform_half_open(bits)), 1 / shape);
  Measurement all;
  all.unit = "N";
  all.scatter = ScatterKind::values;
  all.values = values;
  all.repeats = 60;
  all.value = sample_statistics(values).mean;
  all.minimum = *std::ranges::min_element(values);
  all.maximum = *std::ranges::max_element(values);
  const WeibullFit fit = fit_weibull(all);
  EXPECT_LT(fit.shape_95.low, shape);
  EXPECT_GT(fit.shape_95.high, shape);
  const double load = 800;
  const double truth = -std::expm1(-std::pow(load / scale, shape));
  const BreakageProbability p = breakage_weibull({{load}}, fit);
  EXPECT_LT(p.each.low, truth);
  EXPECT_GT(p.each.high, truth);
  // Smallest, largest and mean contain less information: a wider interval, which covers the truth.
  Measurement summarized = summary(60, all.minimum, all.maximum, all.value);
  const WeibullFit less = fit_weibull(summarized);
  EXPECT_LT(less.shape_95.low, shape);
  EXPECT_GT(less.shape_95.high, shape);
  EXPECT_GT(less.shape_95.high / less.shape_95.low, fit.shape_95.high / fit.shape_95.low);
}

TEST(Damage, WeibullIntervalsOfSummariesCoverTheTruth) {
  std::mt19937_64 bits(7);
  const double shape = 9, scale = 1090, load = 850;
  const double truth = -std::expm1(-std::pow(load / scale, shape));
  int covered = 0;
  const int trials = 120;
  for (int trial = 0; trial < trials; ++trial) {
    std::vector<double> v(7);
    for (double& x : v) x = scale * std::pow(-std::log1p(-uniform_half_open(bits)), 1 / shape);
    const auto [low, high] = std::ranges::minmax(v);
    const BreakageProbability p =
        breakage_weibull({{load}}, fit_weibull(summary(7, low, high, sample_statistics(v).mean)));
    covered += p.each.low <= truth && truth <= p.each.high;
  }
  EXPECT_GE(covered, 0.95 * trials - 3 * std::sqrt(trials * 0.05 * 0.95));
}

TEST(Censored, KaplanAndMeierAsPrinted) {
  const EmpiricalCdf s = kaplan_meier(treated);
  EXPECT_THAT(s.x, testing::ElementsAre(6, 7, 10, 13, 16, 22, 23));
  const std::vector<double> inside = {0.8571, 0.8067, 0.7529, 0.6902, 0.6275, 0.5378, 0.4482};
  const std::vector<double> error = {0.0764, 0.0869, 0.0963, 0.1068, 0.1141, 0.1282, 0.1346};
  for (std::size_t i = 0; i < inside.size(); ++i) {
    EXPECT_NEAR(1 - s.share[i], inside[i], 1e-4);
    EXPECT_NEAR(s.error[i], error[i], 1e-4);
  }
  // Without censored times it is the share of those at or below.
  EXPECT_NEAR(kaplan_meier(placebo).share[2], 5.0 / 21, 1e-12);
  EXPECT_NEAR(kaplan_meier(placebo).share.back(), 1, 1e-12);
}

}  // namespace
}  // namespace firn
