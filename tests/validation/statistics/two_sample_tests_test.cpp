#include "validation/statistics/two_sample_tests.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "experiments/analysis/random_stream.h"
#include "tests/validation/statistics/samples.h"
#include "validation/statistics/outlier_test.h"

namespace firn {
namespace {

using samples::placebo;
using samples::treated;

double cdf(const std::vector<double>& sample, double x) {
  return static_cast<double>(std::ranges::count_if(sample, [&](double v) { return v <= x; })) /
         static_cast<double>(sample.size());
}

// The referee: both distances by their definitions.
double smirnov(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0;
  for (const auto* s : {&a, &b})
    for (const double x : *s) most = std::max(most, std::abs(cdf(a, x) - cdf(b, x)));
  return most;
}
double area(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> all = a;
  all.insert(all.end(), b.begin(), b.end());
  std::ranges::sort(all);
  double sum = 0;
  for (std::size_t i = 0; i + 1 < all.size(); ++i)
    sum += (all[i + 1] - all[i]) * std::abs(cdf(a, all[i]) - cdf(b, all[i]));
  return sum;
}

// And the shares of all ways to split in which they are as large.
std::pair<double, double> brute(std::vector<double> a, const std::vector<double>& b) {
  const double d = smirnov(a, b) - 1e-9, w = area(a, b) * (1 - 1e-9) - 1e-12;
  const std::size_t n = a.size();
  a.insert(a.end(), b.begin(), b.end());
  std::vector<bool> in(a.size(), false);
  std::fill(in.begin(), in.begin() + static_cast<std::ptrdiff_t>(n), true);
  double by_d = 0, by_w = 0, all = 0;
  do {
    std::vector<double> x, y;
    for (std::size_t i = 0; i < a.size(); ++i) (in[i] ? x : y).push_back(a[i]);
    by_d += smirnov(x, y) >= d;
    by_w += area(x, y) >= w;
    ++all;
  } while (std::prev_permutation(in.begin(), in.end()));
  return {by_d / all, by_w / all};
}

TEST(Exchange, IsExactForSmallSamplesWithAndWithoutTies) {
  EXPECT_NEAR(exchange_test({1, 2, 3, 4, 5}, {6, 7, 8, 9, 10}).distance_p, 2.0 / 252, 1e-12);
  EXPECT_NEAR(exchange_test({1, 2, 3}, {1.5, 2.5, 3.5}).area, 0.5, 1e-15);
  EXPECT_NEAR(exchange_test({0, 0, 0, 1}, {0, 1}).area, 0.25, 1e-15);
  EXPECT_EQ(exchange_test({1, 2, 3}, {3, 1, 2}).area, 0);
  std::mt19937_64 bits(2);
  for (int trial = 0; trial < 60; ++trial) {
    std::vector<double> a(2 + trial % 5), b(1 + trial % 6);
    for (auto* s : {&a, &b})
      for (double& v : *s) v = std::floor(uniform_half_open(bits) * (trial % 3 == 0 ? 4 : 1000));
    const SampleTest t = exchange_test(a, b);
    const auto [by_distance, by_area] = brute(a, b);
    EXPECT_NEAR(t.distance, smirnov(a, b), 1e-12) << trial;
    EXPECT_NEAR(t.area, area(a, b), 1e-9) << trial;
    EXPECT_NEAR(t.distance_p, by_distance, 1e-12) << trial;
    EXPECT_NEAR(t.area_p, by_area, 1e-12) << trial;
    EXPECT_GE(t.p, std::min(by_distance, by_area) - 1e-12) << trial;
    EXPECT_LE(t.p, 2 * std::min(by_distance, by_area) + 1e-12) << trial;
  }
}

TEST(Exchange, StatesWhichSizesCannotDecide) {
  EXPECT_GT(exchange_test({1, 2, 3}, {1.1, 2.1, 3.1}).critical, 1);  // 2 of 20 splits at best
  EXPECT_LE(exchange_test({1, 2, 3, 4}, {1.1, 2.1, 3.1, 4.1}).critical, 1);  // 2 of 70
}

TEST(OpenTimes, DistinguishSamples) {
  const SampleTest t = compare_open_times({treated}, placebo);
  EXPECT_GT(t.distance, 0.5);
  EXPECT_LT(t.p, 0.01);
  EXPECT_EQ(compare_open_times({treated}, treated).distance, 0);
  EXPECT_EQ(compare_open_times({{{1, 2}, {}}}, {{1, 2}, {}}).p, 1);
  EXPECT_NEAR(compare_open_times({{{1, 2}, {}}}, {{3, 4}, {}}).distance_p, 2.0 / 6, 1e-12);
}

TEST(OpenTimes, CompareAfterTheLastPassageOfTheShorterList) {
  // All of one have passed by 2; of the other one passes at 1, and nineteen stay until 50.
  const CensoredTimes quick{std::vector<double>(20, 2.0), {}};
  const CensoredTimes slow{{1}, std::vector<double>(19, 50.0)};
  EXPECT_NEAR(compare_open_times({quick}, slow).distance, 0.95, 1e-12);
  // A watch that ends at 1.5 sees neither.
  const CensoredTimes short_watch{{1}, std::vector<double>(19, 1.5)};
  EXPECT_NEAR(compare_open_times({quick}, short_watch).distance, 0.05, 1e-12);
}

TEST(ValueApart, IsFoundAmongValuesOfSeveralKinds) {
  std::mt19937_64 bits(11);
  std::normal_distribution<double> normal(0, 1);
  int found = 0, false_alarms = 0, masked = 0;
  const int trials = 400;
  for (int trial = 0; trial < trials; ++trial) {
    std::vector<double> v(8 + trial % 40);
    const int kind = trial % 4;
    for (double& x : v)
      x = kind == 0   ? 10 + normal(bits)
          : kind == 1 ? std::exp(0.4 * normal(bits))
          : kind == 2 ? -std::log1p(-uniform_half_open(bits))
                      : 1 + uniform_half_open(bits);
    false_alarms += value_apart(v).has_value();
    if (kind == 2) continue;  // a tenfold exponential value is one in 20 000, no impossible one
    v[v.size() / 2] *= 10;
    const auto apart = value_apart(v);
    found += apart && *apart == v[v.size() / 2];
    if (v.size() < 20) continue;
    v[1] *= 10;
    masked += value_apart(v).has_value() ? 0 : 1;
  }
  EXPECT_LE(false_alarms, 0.06 * trials);
  EXPECT_GE(found, 0.95 * 0.75 * trials);
  EXPECT_LE(masked, 0.02 * trials);
  EXPECT_FALSE(value_apart({1, 1, 1, 10}));  // four values are too few
  EXPECT_EQ(value_apart({1, 1, 1, 1, 10}), 10);
  EXPECT_FALSE(value_apart({1, 1, 1, 1, 1}));
}

TEST(TaskAffinity, DistanceAndProbability) {
  EXPECT_NEAR(total_variation_distance({10, 0}, {0, 4}), 1, 1e-15);
  EXPECT_NEAR(total_variation_distance({2, 2}, {3, 1}), 0.25, 1e-15);
  EXPECT_GT(compare_shares({{10, 10, 10}}, {5, 6, 4}).p, 0.5);
  EXPECT_LT(compare_shares({{30, 2, 3}}, {3, 20, 18}).p, 0.001);
  EXPECT_GT(compare_shares({{1, 1}}, {1, 1}).critical, 1);
}

TEST(TaskAffinity, ScatterFromRunToRunCountsOnlyBeyondAMultinomial) {
  // Runs that agree better than chance are no better known.
  const ShareTest even = compare_shares({{20, 20}, {20, 20}, {20, 20}}, {14, 26});
  EXPECT_EQ(even.dispersion, 1);
  EXPECT_EQ(even.p, compare_shares({{60, 60}}, {14, 26}).p);
  // Runs of which each is all of one class: 12 of 40 are what one more run could have.
  const ShareTest clumped = compare_shares({{30, 10}, {8, 32}, {31, 9}, {11, 29}}, {12, 28});
  EXPECT_GT(clumped.dispersion, 5);
  EXPECT_GT(clumped.p, 0.3);
}

}  // namespace
}  // namespace firn
