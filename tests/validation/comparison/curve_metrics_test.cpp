#include "validation/comparison/curve_metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace firn {
namespace {

using Align = MeasuredData::Alignment;

SampledCurve sampled(double from, double to, int n, double (*f)(double)) {
  SampledCurve c;
  for (int i = 0; i <= n; ++i) {
    c.x.push_back(from + (to - from) * i / n);
    c.y.push_back(f(c.x.back()));
  }
  return c;
}
double bump(double x) { return std::exp(-x * x); }
double line(double x) { return 3 * x; }

TEST(Curves, AreStraightBetweenSamplesAndInOrder) {
  const SampledCurve c = in_order({{2, 0, 1, 1, NAN}, {4, 0, 2, 7, 1}});
  ASSERT_EQ(c.x.size(), 3U);
  EXPECT_EQ(curve_at(c, 0.5), 1);
  EXPECT_EQ(curve_at(c, 1.5), 3);
  EXPECT_EQ(curve_at(c, -1), 0);
  EXPECT_EQ(curve_at(c, 9), 4);
}

TEST(Curves, OfOneFunctionAgreeHoweverTheyAreSampled) {
  const auto c =
      compare_curves({sampled(0, 4, 400, line)}, {sampled(-1, 3, 37, line)}, Align::none);
  ASSERT_TRUE(c);
  EXPECT_EQ(c->x.front(), 0);  // where both reach
  EXPECT_EQ(c->x.back(), 3);
  EXPECT_NEAR(c->difference, 0, 1e-12);
  EXPECT_NEAR(c->range, 9, 1e-12);
  EXPECT_TRUE(std::isnan(c->measured_error[5]));
}

TEST(Curves, StateDifferenceAndUncertainty) {
  // A constant offset of 1 on a range of 6, two runs that differ by 0.4, two equal repeats.
  const auto shifted = [](double by) {
    SampledCurve c = sampled(0, 2, 50, line);
    for (double& y : c.y) y += by;
    return c;
  };
  const auto c =
      compare_curves({shifted(0.8), shifted(1.2)}, {shifted(0), shifted(0)}, Align::none);
  ASSERT_TRUE(c);
  EXPECT_NEAR(c->difference, 1.0 / 6, 1e-12);
  EXPECT_NEAR(c->largest, 1.0 / 6, 1e-9);
  const double variance = 0.4 * 0.4 / 2 / 2;  // of the mean of two
  EXPECT_NEAR(c->uncertainty, std::sqrt(variance) / 6, 1e-9);
  EXPECT_NEAR(c->expanded, 12.706 * std::sqrt(variance) / 6, 0.02);  // Student, one degree
  EXPECT_FALSE(compare_curves({shifted(0)}, {sampled(5, 6, 9, line)}, Align::none));
}

TEST(Curves, AreLaidOverEachOtherByOnsetOrByFit) {
  SampledCurve late = sampled(-4, 4, 800, bump);
  for (double& x : late.x) x += 0.7;
  const SampledCurve other = sampled(-4, 4, 530, bump);
  EXPECT_NEAR(best_shift(late, other), -0.7, 1e-3);
  const auto best = compare_curves({late}, {other}, Align::best);
  EXPECT_NEAR(best->shift, -0.7, 1e-3);
  EXPECT_LT(best->difference, 1e-3);
  EXPECT_GT(compare_curves({late}, {other}, Align::none)->difference, 0.1);
  EXPECT_LT(compare_curves({late}, {other}, Align::onset)->difference, 0.02);
  // A twentieth of the largest: exp(-x^2) = 0.05.
  const SampledCurve onset = from_onset(sampled(-4, 4, 8000, bump));
  EXPECT_NEAR(onset.x.front(), -4 + std::sqrt(std::log(20)), 2e-3);
}

}  // namespace
}  // namespace firn
