// Every case of `firn verify`, as tests.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <ostream>

#include "validation/verification/suite.h"

namespace firn::verification {

void PrintTo(const VerificationCase& c, std::ostream* out) { *out << c.title; }

namespace {

using Cases = std::vector<VerificationCase>;

Cases of_tier(Tier tier) {
  Cases cases = all_cases();
  std::erase_if(cases, [&](const VerificationCase& c) { return c.tier != tier; });
  return cases;
}

std::string test_name(const ::testing::TestParamInfo<VerificationCase>& info) {
  std::string name = info.param.name;
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return !std::isalnum(c); }, '_');
  return name;
}

void expect_passes(const VerificationCase& c) {
  const std::vector<Check> checks = c.run();
  EXPECT_FALSE(checks.empty());
  for (const Check& check : checks) {
    EXPECT_TRUE(passed(check)) << check.what << ": " << check.measured << " " << check.unit
                               << " instead of " << check.expected << ", "
                               << tolerance_fraction(check) << " of the tolerance";
  }
}

class Verification : public ::testing::TestWithParam<VerificationCase> {};
TEST_P(Verification, Passes) { expect_passes(GetParam()); }
INSTANTIATE_TEST_SUITE_P(Suite, Verification, ::testing::ValuesIn(of_tier(Tier::quick)), test_name);

class VerificationLong : public ::testing::TestWithParam<VerificationCase> {};
TEST_P(VerificationLong, Passes) { expect_passes(GetParam()); }
INSTANTIATE_TEST_SUITE_P(Suite, VerificationLong, ::testing::ValuesIn(of_tier(Tier::full)),
                         test_name);
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(VerificationLong);

TEST(VerificationCases, AreNamedOnceAndStateWhatTheyCompareWith) {
  const Cases cases = all_cases();
  for (std::size_t i = 0; i < cases.size(); ++i) {
    EXPECT_NE(cases[i].name.find('.'), std::string::npos) << cases[i].name;
    EXPECT_FALSE(cases[i].title.empty()) << cases[i].name;
    EXPECT_FALSE(cases[i].reference.empty()) << cases[i].name;
    for (std::size_t k = 0; k < i; ++k) EXPECT_NE(cases[i].name, cases[k].name);
  }
}

TEST(Check, PassesWithinItsBoundOnly) {
  Check c{.what = "a", .measured = 1.01, .expected = 1, .tolerance = 0.02};
  EXPECT_TRUE(passed(c));
  EXPECT_NEAR(tolerance_fraction(c), 0.5, 1e-12);
  c.tolerance = 0.005;
  EXPECT_FALSE(passed(c));
  c = {.what = "b", .measured = -0.1, .expected = 0, .tolerance = 0.05, .bound = Bound::absolute};
  EXPECT_FALSE(passed(c));
  c = {.what = "c", .measured = 2, .expected = 3, .bound = Bound::at_most};
  EXPECT_TRUE(passed(c));
  c.bound = Bound::at_least;
  EXPECT_FALSE(passed(c));
  c = {.what = "d", .measured = std::nan(""), .expected = 3, .bound = Bound::at_most};
  EXPECT_FALSE(passed(c));
  EXPECT_TRUE(std::isinf(tolerance_fraction(c)));
}

}  // namespace
}  // namespace firn::verification
