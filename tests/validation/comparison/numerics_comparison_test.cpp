// What numerical choices and the stiffness change.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/validation/comparison/compared_runs.h"

namespace firn {
namespace {

using namespace test;
using testing::HasSubstr;

TEST_F(Comparisons, OfChoicesShowWhatStandsOutFromTheSeeds) {
  const RunGroup base = group(RunGroup::Purpose::base, {9, 10, 11, 12});
  const RunGroup half = group(RunGroup::Purpose::timestep, {9.1, 9.9, 11.1}, 5e-6);
  const RunGroup stiff = group(RunGroup::Purpose::stiffness, {20, 21.1, 22}, 1e8);
  RunGroup broken = group(RunGroup::Purpose::variant, {9});
  broken.results[0].status = JobStatus::failed;
  const Variant variant{"broken", {{"a.b", "1"}}, {1}, false};
  what.kind = ComparisonKind::numerical_variants;
  evidence = {&base, nullptr, &base, &half, {&stiff}, 1e7, nullptr};
  evidence.variants = {{&variant, &broken}};
  const Comparison c = result();
  EXPECT_EQ(c.verdict, ValidationVerdict::not_judged);
  ASSERT_EQ(c.variants.size(), 2u);
  EXPECT_EQ(c.variants[0].variant, "time step 5 us");
  EXPECT_EQ(c.variants[0].seeds, 3);
  EXPECT_NEAR(c.variants[0].before, 10, 1e-12);  // over the seeds that both have
  EXPECT_NEAR(c.variants[0].after - c.variants[0].before, 0.1 / 3, 1e-12);
  const double sd = std::sqrt((0.1 * 0.1 + 0.1 * 0.1 + 0.1 * 0.1 - 0.1 * 0.1 / 3) / 2);
  EXPECT_NEAR(c.variants[0].error, sd / std::sqrt(3.0), 1e-12);
  EXPECT_THAT(c.headline, HasSubstr("1 of 2 changes stand out"));
  EXPECT_THAT(c.headline, HasSubstr("from 10 deg to 21 deg with Young's modulus 0.1 GPa"));
  EXPECT_THAT(c.caveats, testing::Contains("broken: no run finished"));
}

TEST_F(Comparisons, OfStiffnessFindAPowerLaw) {
  what.kind = ComparisonKind::stiffness_scaling;
  what.real_modulus = 9.2e9;
  const auto at = [](double modulus) { return 3 * std::sqrt(modulus / 1e7); };
  const RunGroup base = group(RunGroup::Purpose::base, {at(1e7), at(1e7), at(1e7)});
  const RunGroup a = group(RunGroup::Purpose::stiffness, {at(3e7), at(3e7), at(3e7)}, 3e7);
  const RunGroup b = group(RunGroup::Purpose::stiffness, {at(1e8), at(1e8), at(1e8)}, 1e8);
  evidence = {&base, nullptr, &base, nullptr, {&a, &b}, 1e7, nullptr};
  const Comparison c = result();
  ASSERT_EQ(c.stiffness_scaling.size(), 1u);
  EXPECT_NEAR(c.stiffness_scaling[0].exponent, 0.5, 1e-9);
  EXPECT_LT(c.stiffness_scaling[0].extrapolated.low, at(9.2e9));
  EXPECT_GT(c.stiffness_scaling[0].extrapolated.high, at(9.2e9));
  EXPECT_THAT(c.stiffness_scaling[0].interpretation, HasSubstr("92 times beyond"));
  EXPECT_EQ(c.verdict, ValidationVerdict::not_judged);
}

TEST_F(Comparisons, OfStiffnessExtrapolateNothingFromTwoSeeds) {
  what.kind = ComparisonKind::stiffness_scaling;
  what.real_modulus = 9.2e9;
  const auto extrapolated = [&](const RunGroup& base, const RunGroup& a, const RunGroup& b) {
    evidence = {&base, nullptr, &base, nullptr, {&a, &b}, 1e7, nullptr};
    return result().stiffness_scaling.at(0);
  };
  using P = RunGroup::Purpose;
  // Two seeds that scatter, as an angle of repose does: with three degrees of freedom the 95 %
  // would reach far beyond any angle.
  const StiffnessScalingResult two =
      extrapolated(group(P::base, {8, 12}), group(P::stiffness, {13, 9}, 2e7),
                   group(P::stiffness, {14, 9}, 3e7));
  EXPECT_TRUE(std::isnan(two.extrapolated.low));
  EXPECT_TRUE(std::isnan(two.extrapolated.high));
  EXPECT_THAT(two.interpretation, HasSubstr("not enough data to extrapolate"));
  // Nor from three that scatter as much.
  const StiffnessScalingResult three =
      extrapolated(group(P::base, {8, 12, 10}), group(P::stiffness, {13, 9, 11}, 2e7),
                   group(P::stiffness, {14, 9, 11}, 3e7));
  EXPECT_TRUE(std::isnan(three.extrapolated.high));
  EXPECT_THAT(three.interpretation, HasSubstr("spans more than a factor of 10"));
}

}  // namespace
}  // namespace firn
