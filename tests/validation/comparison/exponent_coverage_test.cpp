// How often the stated errors of exponents over the stiffness, and extrapolations by them, hold the
// truth. The long tier takes 1000 sets for each number of runs and prints the table of
// docs/validation.md.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <random>

#include "experiments/analysis/random_stream.h"
#include "tests/validation/comparison/compared_runs.h"
#include "validation/comparison/stiffness_scaling.h"

namespace firn {
namespace {

// Exponents over three stiffnesses with n runs each.
struct Coverage {
  double one_error = 0, extrapolated = 0, refused = 0;
};
Coverage coverage(int n, int suites) {
  std::mt19937_64 random(static_cast<std::uint64_t>(n));
  Coverage c;
  int given = 0;
  for (int i = 0; i < suites; ++i) {
    std::vector<RunGroup> groups;
    for (const double modulus : {1e7, 3e7, 1e8}) {
      std::vector<double> angles(static_cast<std::size_t>(n));
      for (double& a : angles)
        a = 10 * std::sqrt(modulus / 1e7) * std::exp(0.15 * normal_deviate(random));
      groups.push_back(test::group(RunGroup::Purpose::stiffness, angles, modulus));
    }
    ComparisonRuns e;
    e.base = &groups[0];
    e.base_modulus = 1e7;
    e.stiffness = {&groups[1], &groups[2]};
    const StiffnessScalingResult s = fit_stiffness_scaling("angle", e, 3e8);
    c.one_error += (std::abs(s.exponent - 0.5) <= s.exponent_error) / static_cast<double>(suites);
    if (!std::isfinite(s.extrapolated.low)) continue;
    ++given;
    const double truth = 10 * std::sqrt(30.0);
    c.extrapolated += s.extrapolated.low <= truth && truth <= s.extrapolated.high;
  }
  c.refused = 1 - static_cast<double>(given) / suites;
  c.extrapolated = given > 0 ? c.extrapolated / given : 1;
  return c;
}

void expect_coverage(const std::vector<int>& numbers, int suites) {
  const double scatter = std::sqrt(0.32 * 0.68 / suites);
  for (const int n : numbers) {
    const Coverage c = coverage(n, suites);
    std::cout << fmt::format("| exponent | {} | {:.0f} | {:.0f} | {:.0f} |\n", n, 100 * c.one_error,
                             100 * c.extrapolated, 100 * c.refused);
    EXPECT_GE(c.one_error, 0.68 - 0.03 - 3 * scatter) << n;
    // Many runs that scatter by 15 % know a mean better than the 2 % that it counts as.
    EXPECT_LE(c.one_error, 0.68 + (n > 10 ? 0.15 : 0.05) + 3 * scatter) << n;
    EXPECT_GE(c.extrapolated, 0.93 - 3 * scatter) << n;
    if (n < 3) {
      EXPECT_EQ(c.refused, 1);
    }
  }
}

TEST(ExponentCoverage, IsWhatTheErrorSays) { expect_coverage({2, 5}, 300); }
TEST(ExponentCoverageLong, IsWhatTheErrorSays) {
  std::cout << "| | n | within one error, % | extrapolation within 95 %, % | refused, % |\n";
  expect_coverage({2, 3, 5, 10, 20, 50}, 1000);
}

}  // namespace
}  // namespace firn
