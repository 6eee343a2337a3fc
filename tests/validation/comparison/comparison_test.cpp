// Comparisons of single values.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "experiments/analysis/sample_statistics.h"
#include "tests/validation/comparison/compared_runs.h"

namespace firn {
namespace {

using namespace test;
using testing::HasSubstr;
using testing::ThrowsMessage;

TEST_F(Comparisons, OfAValueAddUpItsUncertainties) {
  const RunGroup base = group(RunGroup::Purpose::base, {9, 10, 11, 10, 9, 11, 10, 9, 11, 10});
  const RunGroup half = group(RunGroup::Purpose::timestep, {9.3, 10.3, 11.3}, 1e-5);
  const RunGroup stiff = group(RunGroup::Purpose::stiffness, {8.6, 9.6, 10.6}, 1e8);
  const RunGroup input = group(RunGroup::Purpose::input, {7, 13, 7, 13, 7, 13});
  evidence = {&base, &input, &base, &half, {&stiff}, 1e7, nullptr};
  const Comparison c = result();
  ASSERT_TRUE(c.value);
  const ValueComparison& v = *c.value;
  EXPECT_NEAR(v.difference, 0, 1e-12);
  ASSERT_EQ(v.components.size(), 5u);
  const double sd = std::sqrt(6.0 / 9);  // of the ten values
  EXPECT_NEAR(*v.components[0].value, sd / std::sqrt(10.0), 1e-12);
  EXPECT_NEAR(*v.components[1].value, 0.3, 1e-9);  // the same for every seed
  EXPECT_NEAR(*v.components[2].value, 0.4, 1e-9);
  EXPECT_NEAR(*v.components[3].value, std::sqrt(54.0 / 5 - 6.0 / 9), 1e-12);
  EXPECT_NEAR(*v.components[4].value, 0.1, 1e-12);
  double sum = 0;
  for (const UncertaintyComponent& p : v.components) sum += *p.value * *p.value;
  EXPECT_NEAR(v.uncertainty, std::sqrt(sum), 1e-12);
  EXPECT_GT(v.expanded, 2 * v.uncertainty);  // most of it is from six draws
  EXPECT_EQ(v.p_value, 1);                   // no difference
  EXPECT_EQ(c.verdict, ValidationVerdict::consistent);
  EXPECT_FALSE(v.area);  // a mean and a scatter are no distribution
}

TEST_F(Comparisons, JudgeByDifferenceUncertaintyAndTolerance) {
  const RunGroup near = group(RunGroup::Purpose::base, {10, 10.2, 9.8, 10.1, 9.9});
  const RunGroup far = group(RunGroup::Purpose::base, {12, 12.2, 11.8, 12.1, 11.9});
  const RunGroup wide = group(RunGroup::Purpose::base, {4, 16, 10, 7, 13});
  const RunGroup one = group(RunGroup::Purpose::base, {10});
  const auto verdict = [&](const RunGroup& base, std::optional<double> tolerance) {
    evidence = {};
    evidence.base = evidence.numerics_base = &base;
    what.tolerance = tolerance;
    return result().verdict;
  };
  EXPECT_EQ(verdict(near, {}), ValidationVerdict::consistent);
  EXPECT_EQ(verdict(near, 1), ValidationVerdict::consistent);
  EXPECT_EQ(verdict(far, {}), ValidationVerdict::inconsistent);
  EXPECT_EQ(verdict(far, 5), ValidationVerdict::consistent);  // it does not matter
  EXPECT_EQ(verdict(wide, 1), ValidationVerdict::inconclusive);
  EXPECT_THAT(result().recommended_action, HasSubstr("seeds"));
  EXPECT_EQ(verdict(one, {}), ValidationVerdict::inconclusive);
  EXPECT_THAT(result().recommended_action, HasSubstr("more than one run"));
}

TEST_F(Comparisons, OfAValueCountNumericalVariantsOnly) {
  const RunGroup base = group(RunGroup::Purpose::base, {9, 10, 11});
  const RunGroup coarse = group(RunGroup::Purpose::variant, {9.5, 10.5, 11.5});
  const Variant mesh{"68 facets", {{"shapes.cube.facets", "68"}}, {1, 2, 3}, true};
  const Variant other{"slower sampling", {{"a.b", "1"}}, {1, 2, 3}, false};
  evidence.base = evidence.numerics_base = &base;
  evidence.variants = {{&mesh, &coarse}, {&other, &coarse}};
  const Comparison c = result();
  ASSERT_EQ(c.value->components.size(), 6u);
  EXPECT_EQ(c.value->components.back().name, "68 facets");
  EXPECT_NEAR(*c.value->components.back().value, 0.5, 1e-12);
}

TEST_F(Comparisons, OfAValueTakeTheOrderOfThreeTimeSteps) {
  const RunGroup base = group(RunGroup::Purpose::base, {10, 11, 12});
  const RunGroup half = group(RunGroup::Purpose::timestep, {9.5, 10.5, 11.5}, 1e-5);
  const RunGroup quarter = group(RunGroup::Purpose::timestep, {9.25, 10.25, 11.25}, 5e-6);
  evidence.base = evidence.numerics_base = &base;
  evidence.timestep = &quarter;
  evidence.timesteps = {&half, &quarter};
  const UncertaintyComponent p = result().value->components[1];
  EXPECT_NEAR(*p.value, 1.25 * 1 / 2, 1e-9);  // first order: off by 1
  EXPECT_THAT(p.evaluation_method, HasSubstr("observed order 1 over three levels"));
  const RunGroup noisy = group(RunGroup::Purpose::timestep, {10, 9, 12.5}, 5e-6);
  evidence.timestep = &noisy;
  evidence.timesteps = {&half, &noisy};
  EXPECT_THAT(result().value->components[1].evaluation_method, HasSubstr("the seeds hide it"));
}

TEST_F(Comparisons, SayWhichRunsAreMissing) {
  RunGroup base = group(RunGroup::Purpose::base, {10, NAN, 10.1});
  JobResult failed;
  failed.status = JobStatus::failed;
  failed.reason = "deep overlap";
  base.results.push_back(failed);
  base.seeds.push_back(4);
  evidence.base = evidence.numerics_base = &base;
  const Comparison c = result();
  EXPECT_EQ(c.finished, 3);
  EXPECT_EQ(c.value->simulation.count, 2);
  EXPECT_THAT(c.caveats, testing::Contains(HasSubstr("1 of 3 runs")));
  EXPECT_THAT(c.caveats, testing::Contains(HasSubstr("deep overlap")));
}

TEST_F(Comparisons, JudgeNoValueWhereRunsAreMissing) {
  std::vector<double> values(19, 10);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] += i % 2 == 0 ? 0.1 : -0.1;
  what.tolerance = 1;
  const auto judge = [&](double value, int failures) {
    std::vector<double> shifted = values;
    for (double& v : shifted) v += value - 10;
    RunGroup base = group(RunGroup::Purpose::base, shifted);
    for (int i = 0; i < failures; ++i) base.results.emplace_back();
    base.seeds.resize(base.results.size(), 99);
    evidence.base = evidence.numerics_base = &base;
    return result();
  };
  using V = ValidationVerdict;
  EXPECT_EQ(judge(10, 0).verdict, V::consistent);
  EXPECT_EQ(judge(15, 0).verdict, V::inconsistent);
  EXPECT_EQ(judge(10, 1).verdict, V::consistent);  // one of twenty
  EXPECT_EQ(judge(15, 1).verdict, V::inconsistent);
  EXPECT_EQ(judge(10, 2).verdict, V::inconclusive);
  EXPECT_EQ(judge(15, 2).verdict, V::inconclusive);
  EXPECT_THAT(judge(15, 2).headline, HasSubstr("2 of 21 runs gave no result"));
  EXPECT_THAT(judge(15, 2).recommended_action, HasSubstr("why"));
}

TEST_F(Comparisons, RefuseAnotherUnitAndAnUnknownResponse) {
  const RunGroup base = group(RunGroup::Purpose::base, {10, 11});
  evidence.base = evidence.numerics_base = &base;
  what.measurement.unit = "rad";
  EXPECT_THAT([&] { result(); }, ThrowsMessage<InputError>(HasSubstr("expected \"deg\"")));
  what.responses = {"ange"};
  EXPECT_THAT([&] { result(); }, ThrowsMessage<InputError>(HasSubstr("one of angle")));
}

TEST_F(Comparisons, OfAValueDoNotPassWithOneThatStandsApart) {
  const RunGroup base = group(RunGroup::Purpose::base, {10, 10.2, 9.8, 10.1, 9.9});
  evidence.base = evidence.numerics_base = &base;
  Measurement& m = what.measurement;
  m.scatter = ScatterKind::values;
  m.values = {10, 9, 11, 10, 10.5, 9.5, 100};
  const SampleStatistics f = sample_statistics(m.values);
  m.value = f.mean;
  m.standard_deviation = f.deviation;
  m.repeats = f.count;
  EXPECT_EQ(result().verdict, ValidationVerdict::inconclusive);
  m.values.back() = 10;
  m.value = 10;
  m.standard_deviation = 0.7;
  EXPECT_EQ(result().verdict, ValidationVerdict::consistent);
  const RunGroup wild = group(RunGroup::Purpose::base, {10, 10.2, 9.8, 10.1, 9.9, 10.3, 100});
  evidence.base = evidence.numerics_base = &wild;
  EXPECT_NE(result().verdict, ValidationVerdict::consistent);
}

// The uncertainty has two digits, and the difference ends at the same decimal place.
TEST_F(Comparisons, OfAValueStateAsManyDigitsAsTheyKnow) {
  const RunGroup base = group(RunGroup::Purpose::base, {9.1, 10.2, 11.3});
  evidence.base = evidence.numerics_base = &base;
  EXPECT_THAT(result().headline, testing::ContainsRegex("higher by 0\\.2 ± [1-9]\\.[0-9] deg"));
  const RunGroup wide = group(RunGroup::Purpose::base, {10, 40, 70});
  evidence.base = evidence.numerics_base = &wide;
  EXPECT_THAT(result().headline, testing::ContainsRegex("higher by 30 ± [1-9][0-9] deg"));
  // Rounding errors of zero are zero.
  const RunGroup none = group(RunGroup::Purpose::base, {-3.6e-25, 1e-24, -2e-25});
  evidence.base = evidence.numerics_base = &none;
  EXPECT_THAT(result().headline, HasSubstr("simulated 0 deg, measured 10 deg: lower by 10."));
}

}  // namespace
}  // namespace firn
