#include "experiments/analysis/folded_curve.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace firn {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;
using testing::Pointwise;

// y is the remainder itself, in many passes from below 0 on: the mean of a bin is its middle.
TEST(FoldedCurve, OfASawtoothHasTheMiddlesOfTheBins) {
  std::vector<double> x, y;
  const int per_bin = 10, bins = 8;
  for (int i = -5 * per_bin * bins; i < 20 * per_bin * bins; ++i) {
    x.push_back((i + 0.5) / (per_bin * bins) * 2.5);
    y.push_back(x.back() - 2.5 * std::floor(x.back() / 2.5));
  }
  const FoldedCurve folded = folded_curve(x, y, 2.5, bins);
  ASSERT_EQ(folded.x.size(), 8U);
  EXPECT_THAT(folded.mean, Pointwise(DoubleNear(1e-12), folded.x));
  for (int k = 0; k < bins; ++k) {
    const auto at = static_cast<std::size_t>(k);
    EXPECT_NEAR(folded.x[at], (k + 0.5) * 2.5 / bins, 1e-12);
    EXPECT_NEAR(folded.least[at], (k + 0.05) * 2.5 / bins, 1e-12);
    EXPECT_NEAR(folded.most[at], (k + 0.95) * 2.5 / bins, 1e-12);
  }
}

TEST(FoldedCurve, CombinesPassesBelowAndAboveZero) {
  const FoldedCurve folded =
      folded_curve(std::vector<double>{-0.5, 0.5, 1.5, 3.5, -3.5},
                   std::vector<double>{1, 2, 3, 4, 9}, 2, 2);  // remainders 1.5, 0.5, 1.5, 1.5, 0.5
  EXPECT_THAT(folded.x, ElementsAre(0.5, 1.5));
  EXPECT_THAT(folded.mean, ElementsAre(5.5, 8.0 / 3));
  EXPECT_THAT(folded.least, ElementsAre(2, 1));
  EXPECT_THAT(folded.most, ElementsAre(9, 4));
}

// Of a period without an exact number, and with rounding to either side.
TEST(FoldedCurve, MultiplesOfThePeriodAreInTheFirstBin) {
  const double turn = 4 * std::numbers::pi;
  std::vector<double> x;
  for (int k = -300; k <= 300; ++k) {
    x.push_back(k * turn);
    x.push_back(std::nextafter(k * turn, -1e9));
  }
  const FoldedCurve folded = folded_curve(x, std::vector<double>(x.size(), 7), turn, 144);
  EXPECT_THAT(folded.x, ElementsAre(turn / 288));
  EXPECT_THAT(folded.mean, ElementsAre(7));
}

TEST(FoldedCurve, LeavesOutEmptyBinsAndValuesThatAreNotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const FoldedCurve folded = folded_curve(std::vector<double>{0.5, 1.5, nan, 3.5},
                                          std::vector<double>{1, nan, 3, 4}, 4, 4);
  EXPECT_THAT(folded.x, ElementsAre(0.5, 3.5));
  EXPECT_THAT(folded.mean, ElementsAre(1, 4));
  EXPECT_TRUE(folded_curve({}, {}, 1, 3).x.empty());
}

}  // namespace
}  // namespace firn
