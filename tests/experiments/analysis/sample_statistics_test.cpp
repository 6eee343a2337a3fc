#include "experiments/analysis/sample_statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "experiments/analysis/random_stream.h"

namespace firn {
namespace {

TEST(BinomialInterval, IsClopperAndPearsons) {
  // None of n: the upper end solves (1 - p)^n = 0.025.
  EXPECT_EQ(binomial_interval(0, 10).low, 0);
  EXPECT_NEAR(binomial_interval(0, 10).high, 1 - std::pow(0.025, 0.1), 1e-12);
  EXPECT_EQ(binomial_interval(10, 10).high, 1);
  EXPECT_NEAR(binomial_interval(10, 10).low, std::pow(0.025, 0.1), 1e-12);
  // Ends solve sums of binomial probabilities.
  const Interval i = binomial_interval(3, 8);
  const auto at_least = [](int k, int n, double p) {
    double sum = 0;
    for (int j = k; j <= n; ++j)
      sum += std::exp(std::lgamma(n + 1.0) - std::lgamma(j + 1.0) - std::lgamma(n - j + 1.0) +
                      j * std::log(p) + (n - j) * std::log(1 - p));
    return sum;
  };
  EXPECT_NEAR(at_least(3, 8, i.low), 0.025, 1e-9);
  EXPECT_NEAR(1 - at_least(4, 8, i.high), 0.025, 1e-9);
}

TEST(BinomialInterval, CoversAtLeastAsOftenAsItSays) {
  std::mt19937_64 bits(1);
  for (const double p : {0.02, 0.3, 0.9}) {
    int covered = 0;
    for (int trial = 0; trial < 4000; ++trial) {
      int hits = 0;
      for (int k = 0; k < 9; ++k) hits += uniform_half_open(bits) < p;
      const Interval i = binomial_interval(hits, 9);
      covered += i.low <= p && p <= i.high;
    }
    EXPECT_GE(covered, 0.95 * 4000 - 3 * std::sqrt(4000 * 0.05 * 0.95));
  }
}

// Of the table of Clopper and Pearson: 0 and 3 of 10.
TEST(BinomialInterval, AgreesWithPublishedValues) {
  EXPECT_NEAR(binomial_interval(0, 10).high, 0.3085, 5e-5);
  EXPECT_NEAR(binomial_interval(3, 10).low, 0.0667, 5e-5);
  EXPECT_NEAR(binomial_interval(3, 10).high, 0.6525, 5e-5);
  EXPECT_EQ(binomial_interval(10, 10).high, 1);
  EXPECT_EQ(binomial_interval(0, 0).low, 0);
  EXPECT_EQ(binomial_interval(0, 0).high, 1);
}

TEST(WeightedQuantile, IsTheFirstValueThatReachesItsShare) {
  const std::vector<double> x = {3, 1, 2}, weight = {0.5, 0.3, 0.2};
  EXPECT_EQ(weighted_quantile(x, weight, 0), 1);
  EXPECT_EQ(weighted_quantile(x, weight, 0.3), 1);
  EXPECT_EQ(weighted_quantile(x, weight, 0.31), 2);
  EXPECT_EQ(weighted_quantile(x, weight, 0.6), 3);
  EXPECT_EQ(weighted_quantile(x, weight, 1.1), 3);  // more than all: the largest
}

// Of tables of Student's distribution.
TEST(StudentFactor, AgreesWithPublishedValues) {
  EXPECT_NEAR(student_factor(1), 12.706, 5e-4);
  EXPECT_NEAR(student_factor(10), 2.228, 5e-4);
  EXPECT_NEAR(student_factor(4, 0.99), 4.604, 5e-4);
  EXPECT_NEAR(student_factor(60, 0.99), 2.660, 5e-4);
}

TEST(SampleStatistics, OfNoneAndOneValue) {
  EXPECT_TRUE(std::isnan(sample_statistics({}).mean));
  EXPECT_EQ(sample_statistics({3}).mean, 3);
  EXPECT_TRUE(std::isnan(sample_statistics({3}).deviation));
  EXPECT_TRUE(std::isnan(sample_statistics({3}).error()));
  EXPECT_DOUBLE_EQ(sample_statistics({1, 3}).deviation, std::sqrt(2.0));
  EXPECT_DOUBLE_EQ(sample_statistics({1, 3}).error(), 1);
}

}  // namespace
}  // namespace firn
