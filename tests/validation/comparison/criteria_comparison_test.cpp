// Statements about runs, and distributions.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/validation/comparison/compared_runs.h"

namespace firn {
namespace {

using namespace test;
using testing::HasSubstr;
using testing::ThrowsMessage;

// `holds`, `others` runs in which the angle is above 5 deg or not, and failed ones.
RunGroup with_failures(int holds, int others, int failures) {
  std::vector<double> values(static_cast<std::size_t>(holds), 10);
  values.resize(static_cast<std::size_t>(holds + others), 1);
  RunGroup g = group(RunGroup::Purpose::base, values);
  for (int i = 0; i < failures; ++i) {
    g.seeds.push_back(g.seeds.size() + 1);
    g.results.push_back({});
    g.results.back().reason = "the arm is held down";
  }
  return g;
}

// A statement is decided only where it would be for every outcome of the missing runs.
TEST_F(Comparisons, OfClaimsAllowForEveryOutcomeOfMissingRuns) {
  what.kind = ComparisonKind::criteria;
  std::mt19937_64 bits(4711);
  const auto draw = [&](int n) { return static_cast<int>(bits() % static_cast<unsigned>(n)); };
  const auto verdict = [&](int holds, int others, int failures) {
    const RunGroup base = with_failures(holds, others, failures);
    evidence.base = evidence.numerics_base = &base;
    return result().verdict;
  };
  int decided = 0;
  for (int i = 0; i < 300; ++i) {
    what.measurement.criteria = {{"larger", "angle", "5", 1, draw(2) * (1 + draw(3)), "x"}};
    const int runs = 1 + draw(80), missing = 1 + draw(6);
    const int holds = draw(3) == 0 ? draw(runs + 1) : draw(2) * runs;
    const ValidationVerdict v = verdict(holds, runs - holds, missing);
    if (v == ValidationVerdict::inconclusive) continue;
    ++decided;
    for (int k = 0; k <= missing; ++k)
      EXPECT_EQ(verdict(holds + k, runs - holds + missing - k, 0), v)
          << holds << " of " << runs << ", " << missing << " missing";
  }
  EXPECT_GT(decided, 60);
}

TEST_F(Comparisons, OfClaimsCountFailedRunsWhereTheseAnswer) {
  what.kind = ComparisonKind::criteria;
  const auto judge = [&](int holds, int others, int failures, std::optional<bool> if_run_fails) {
    what.measurement.criteria = {{"larger", "angle", "5", 1, 0, "x", if_run_fails}};
    const RunGroup base = with_failures(holds, others, failures);
    evidence.base = evidence.numerics_base = &base;
    return result();
  };
  using V = ValidationVerdict;
  EXPECT_EQ(judge(5, 0, 1, true).verdict, V::consistent);
  EXPECT_EQ(judge(5, 0, 1, {}).verdict, V::inconclusive);
  EXPECT_EQ(judge(5, 0, 1, false).verdict, V::inconclusive);
  EXPECT_EQ(judge(0, 0, 5, false).verdict, V::inconsistent);
  EXPECT_EQ(judge(0, 0, 5, {}).verdict, V::inconclusive);
  const Comparison c = judge(4, 0, 1, false);
  EXPECT_EQ(c.criteria[0].holds, 4);
  EXPECT_EQ(c.criteria[0].runs, 5);
  EXPECT_EQ(c.criteria[0].failed, 1);
  EXPECT_EQ(c.criteria[0].missing, 0);
  EXPECT_THAT(c.caveats, testing::Contains(HasSubstr("does not hold in a run that fails")));
  EXPECT_THAT(judge(4, 0, 1, {}).caveats, testing::Contains(HasSubstr("1 of 5 runs have no")));
}

TEST_F(Comparisons, OfClaimsCountTheRunsInWhichTheyHold) {
  what.kind = ComparisonKind::criteria;
  Criterion as_a_rule{"larger", "angle", "5", 1, 0, "x"},
      seen_once{"seen", "angle", "20", 1, 1, "x"};
  what.measurement.criteria = {as_a_rule, seen_once};
  const auto verdicts = [&](const std::vector<double>& values) {
    const RunGroup base = group(RunGroup::Purpose::base, values);
    evidence.base = evidence.numerics_base = &base;
    const Comparison c = result();
    return std::pair(c.criteria[0].verdict, c.criteria[1].verdict);
  };
  using V = ValidationVerdict;
  // Five of five: better than one half with 95 % (0.5^5 = 3 %). Four of four are not enough.
  EXPECT_EQ(verdicts({6, 7, 8, 9, 10}).first, V::consistent);
  EXPECT_EQ(verdicts({6, 7, 8, 9}).first, V::inconclusive);
  EXPECT_EQ(verdicts({1, 1, 1, 1, 1}).first, V::inconsistent);
  // What happened once may be rare: none of five does not speak against it, none of 59 does.
  EXPECT_EQ(verdicts({6, 7, 8, 9, 10}).second, V::inconclusive);
  EXPECT_EQ(verdicts({6, 7, 30, 30, 10}).second, V::consistent);
  EXPECT_EQ(verdicts(std::vector<double>(59, 1)).second, V::inconsistent);
  EXPECT_EQ(verdicts(std::vector<double>(58, 1)).second, V::inconclusive);
  const RunGroup base = group(RunGroup::Purpose::base, {6, 7});
  evidence.base = evidence.numerics_base = &base;
  what.measurement.criteria = {as_a_rule};
  EXPECT_EQ(result().recommended_action, "at least 3 more runs with other seeds");
}

TEST_F(Comparisons, OfDataGoBeyondTheWords) {
  what.kind = ComparisonKind::criteria;
  what.measurement.criteria = {{"more than nothing", "angle", "0", 1, 0, "x"}};
  RunGroup base = group(RunGroup::Purpose::base, {1, 2, 3, 4, 5, 6});
  for (JobResult& r : base.results) {
    r.responses.push_back(response("counts", {30, 10}, "1"));
    r.responses.push_back(response("times", {1, 2, 3, NAN}, "s"));
  }
  evidence.base = &base;
  MeasuredData data;
  data.file = "counts.csv";
  data.response = "counts";
  data.kind = MeasuredData::Kind::classes;
  what.measurement.data = data;
  EXPECT_EQ(result().verdict, ValidationVerdict::consistent);
  EXPECT_THAT(result().caveats, testing::Contains(HasSubstr("as counts.csv they would be")));
  // Without the experiment's numbers the runs' own are there all the same, and judge nothing.
  ASSERT_TRUE(result().distribution);
  EXPECT_EQ(result().distribution->verdict, ValidationVerdict::not_judged);
  EXPECT_THAT(result().distribution->simulated, testing::ElementsAre(180, 60));
  EXPECT_THAT(result().distribution->deviation,
              testing::Each(testing::DoubleNear(std::sqrt(0.75 * 0.25 / 40), 1e-12)));
  EXPECT_THAT(result().distribution->classes, testing::ElementsAre("1", "2"));
  data.present = true;
  data.classes = {"left", "right"};
  data.counts = {31, 9};
  what.measurement.data = data;
  EXPECT_EQ(result().verdict, ValidationVerdict::consistent);
  EXPECT_NEAR(result().distribution->distance, 31.0 / 40 - 0.75, 1e-12);
  what.measurement.data->counts = {10, 30};
  EXPECT_EQ(result().verdict, ValidationVerdict::inconsistent);
  what.measurement.data->counts = {10, 30, 1};
  EXPECT_THAT([&] { result(); }, ThrowsMessage<InputError>(HasSubstr("has 3 classes")));
  data.kind = MeasuredData::Kind::values;
  data.response = "times";
  data.unit = "s";
  data.values = {1.1, 2.1, 2.9};
  what.measurement.data = data;
  EXPECT_EQ(result().verdict, ValidationVerdict::inconclusive);
  EXPECT_EQ(result().recommended_action, "more values, measured and simulated");
  for (int k = 0; k < 4; ++k) data.values.insert(data.values.end(), {1.1, 2.1, 2.9});
  what.measurement.data = data;
  EXPECT_EQ(result().verdict, ValidationVerdict::consistent);
  EXPECT_EQ(result().distribution->simulated.size(), 18u);
  EXPECT_NEAR(result().distribution->area, 0.1, 1e-9);  // 1, 2, 3 and 1.1, 2.1, 2.9
  what.measurement.data->values = {11, 12, 13};
  EXPECT_EQ(result().verdict, ValidationVerdict::inconsistent);
}

TEST_F(Comparisons, OfResidenceCountWhatIsStillInside) {
  what.kind = ComparisonKind::criteria;
  what.measurement.criteria = {{"more than nothing", "angle", "0", 1, 0, "x"}};
  RunGroup base = group(RunGroup::Purpose::base, {1, 2, 3, 4, 5, 6});
  for (JobResult& r : base.results) {
    r.responses.push_back(response("bin_residence_times", {1, 2, 3, NAN}, "s"));
    r.responses.push_back(response("bin_censored_times", {40}, "s"));
  }
  evidence.base = &base;
  MeasuredData data;
  data.response = "bin_residence_times";
  data.present = true;
  data.unit = "s";
  data.values = {1, 2, 3, 1, 2, 3, 1, 2, 3, 1, 2, 3};
  data.right_censored = {5, 5, 5, 5};
  what.measurement.data = data;
  const Comparison c = result();
  EXPECT_EQ(c.distribution->verdict, ValidationVerdict::consistent);
  EXPECT_EQ(c.distribution->simulated_at_least.size(), 6u);
  EXPECT_NEAR(c.distribution->distance, 0, 1e-12);  // a quarter stays in both
  EXPECT_THAT(c.headline, HasSubstr("Kaplan and Meier"));
  // As if the two that pass last had: not the same times.
  what.measurement.data->values = {20, 21, 22, 23};
  what.measurement.data->right_censored = {};
  EXPECT_EQ(result().distribution->verdict, ValidationVerdict::inconsistent);
}

TEST_F(Comparisons, OfSeveralClaimsAllowForTheirNumber) {
  what.kind = ComparisonKind::criteria;
  const RunGroup base = group(RunGroup::Purpose::base, {1, 1, 1, 1, 1});
  evidence.base = &base;
  const Criterion no{"no", "angle", "5", 1, 0, "x"}, yes{"yes", "angle", "0", 1, 0, "x"};
  what.measurement.criteria = {no};
  EXPECT_EQ(result().verdict, ValidationVerdict::inconsistent);  // 0 of 5: 3 %
  what.measurement.criteria = {no, yes};
  EXPECT_EQ(result().criteria[0].verdict, ValidationVerdict::inconsistent);
  EXPECT_EQ(result().verdict, ValidationVerdict::inconclusive);  // one of two: 6 %
  EXPECT_THAT(result().headline, HasSubstr("among 2 statements"));
  EXPECT_FALSE(result().recommended_action.empty());
}

}  // namespace
}  // namespace firn
