#include "experiments/analysis/line_fit.h"

#include <gtest/gtest.h>

#include <vector>

#include "experiments/analysis/sample_statistics.h"

namespace firn {
namespace {

TEST(LineFit, BothFindAnExactLine) {
  const std::vector<double> x{-1, 0, 2, 5}, y{5, 3, -1, -7};  // y = 3 - 2 x
  for (const Line& line : {least_squares_line(x, y), theil_sen_line(x, y)}) {
    EXPECT_DOUBLE_EQ(line.slope, -2);
    EXPECT_DOUBLE_EQ(line.intercept, 3);
  }
}

TEST(LineFit, LeastSquaresByHand) {
  // Means 1 and 4/3, sxx = 2, sxy = 1.
  const Line line = least_squares_line(std::vector<double>{0, 1, 2}, std::vector<double>{1, 1, 2});
  EXPECT_DOUBLE_EQ(line.slope, 0.5);
  EXPECT_DOUBLE_EQ(line.intercept, 5.0 / 6);
}

TEST(LineFit, TheilSenShrugsOffAQuarterOfOutliers) {
  std::vector<double> x, y;
  for (int i = 0; i < 40; ++i) {
    x.push_back(i);
    y.push_back(i % 4 == 1 ? 1000.0 * i : 0.2 * i + 1);
  }
  // The 30 clean points make 435 of the 780 pairs: more than half.
  EXPECT_NEAR(theil_sen_line(x, y).slope, 0.2, 1e-12);
  EXPECT_GT(least_squares_line(x, y).slope, 100);
}

TEST(LineFit, TheilSenSkipsPairsOfEqualX) {
  const Line line =
      theil_sen_line(std::vector<double>{0, 0, 1, 1}, std::vector<double>{0, 1, 2, 3});
  EXPECT_DOUBLE_EQ(line.slope, 2);  // of 1, 2, 2, 3
}

TEST(LineFit, MedianOfOddAndEvenCounts) {
  EXPECT_EQ(median({3, 1, 2}), 2);
  EXPECT_EQ(median({4, 1, 3, 2}), 2.5);
  EXPECT_EQ(median({7}), 7);
}

}  // namespace
}  // namespace firn
