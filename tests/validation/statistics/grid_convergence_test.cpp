#include "validation/statistics/grid_convergence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "experiments/analysis/random_stream.h"

namespace firn {
namespace {

// An answer that is off by c h^p on steps of 1, 1/r, 1/r^2.
Levels powers(double truth, double c, double p, double r) {
  return {truth + c, truth + c * std::pow(r, -p), truth + c * std::pow(r, -2 * p), r, 0};
}

TEST(Convergence, FindsTheOrderAndBoundsTheError) {
  std::mt19937_64 bits(3);
  const auto uniform = [&] { return uniform_half_open(bits); };
  for (int trial = 0; trial < 500; ++trial) {
    const double p = 0.5 + 2 * uniform(), r = 1.5 + 2 * uniform(), off = 4 * uniform() - 2;
    const Convergence c = converge(powers(10, off, p, r));
    ASSERT_TRUE(c.order) << p;
    EXPECT_NEAR(*c.order, p, 1e-6);
    // 95 %: two standard deviations hold the error with the factor of safety.
    EXPECT_NEAR(2 * c.uncertainty, 1.25 * std::abs(off), 1e-6 * std::abs(off) + 1e-9);
  }
}

TEST(Convergence, OfAnOrderBeyondTheUsualIsSafer) {
  const Convergence slow = converge(powers(10, 1, 0.2, 2));
  EXPECT_NEAR(*slow.order, 0.2, 1e-9);
  EXPECT_GT(2 * slow.uncertainty, 1.25 * (1 - std::pow(2.0, -0.4)));
}

TEST(Convergence, GivesABoundWhereChanceOrOscillationHidesTheOrder) {
  Levels l = powers(10, 0.1, 1, 2);
  l.error = 0.2;
  const Convergence hidden = converge(l);
  EXPECT_FALSE(hidden.order);
  EXPECT_NEAR(2 * hidden.uncertainty, 0.4, 1e-12);  // twice the error
  EXPECT_THAT(hidden.how, testing::HasSubstr("the seeds hide it"));
  const Convergence oscillates = converge({1, 2, 1.2, 2, 0.01});
  EXPECT_FALSE(oscillates.order);
  EXPECT_NEAR(2 * oscillates.uncertainty, 1, 1e-12);
  EXPECT_FALSE(converge({1, 2, 4, 2, 0.01}).order);  // grows
}

}  // namespace
}  // namespace firn
