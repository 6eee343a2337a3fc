#include "validation/comparison/comparison.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "experiments/responses/response_expression.h"

namespace firn {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::ThrowsMessage;

JobResult finished(const std::vector<Response>& responses) {
  JobResult r;
  r.status = JobStatus::finished;
  r.responses = responses;
  return r;
}

Response response(const std::string& name, std::vector<double> value, const std::string& unit) {
  return {name, std::move(value), {}, unit, "", 1};
}

RunGroup group(RunGroup::Purpose purpose, const std::vector<double>& values, double setting = 0) {
  RunGroup g;
  g.purpose = purpose;
  g.setting = setting;
  for (std::size_t i = 0; i < values.size(); ++i) {
    g.seeds.push_back(i + 1);
    g.results.push_back(finished({response("angle", {values[i]}, "deg")}));
  }
  return g;
}

// An experiment that gives 10 deg ± 0.1 in 100 repeats.
struct Comparisons : testing::Test {
  Comparisons() {
    suite.experiments.push_back({"heap", "", {}, {1, 2, 3}, {}});
    what.kind = ComparisonKind::value;
    what.responses = {"angle"};
    what.measurement.value = 10;
    what.measurement.unit = "deg";
    what.measurement.repeats = 100;
    what.measurement.standard_deviation = 1;
    what.measurement.scatter = ScatterKind::standard_deviation;
    what.measurement.source = "a notebook";
  }
  Comparison result() { return compare(suite, what, {}, evidence); }

  Suite suite;
  SuiteComparison what;
  ComparisonRuns evidence;
};

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

TEST_F(Comparisons, RefuseTheMeasurementThatTheParametersWereFittedTo) {
  const RunGroup base = group(RunGroup::Purpose::base, {10, 10.2, 9.8});
  MaterialRecord record;
  record.name = "ice";
  record.version = 3;
  record.provenance.measurements = {{"m", "angle", 10, 0.1, "deg", "a notebook (heap.toml)"}};
  evidence.base = evidence.numerics_base = &base;
  evidence.material = &record;
  EXPECT_EQ(result().verdict, ValidationVerdict::not_independent);
  EXPECT_THAT(result().headline, HasSubstr("ice@3 was calibrated to this measurement"));
  record.provenance.measurements[0].source = "another notebook";
  record.provenance.measurements[0].value = 11;
  EXPECT_EQ(result().verdict, ValidationVerdict::consistent);
  what.calibrated_by_design = "the slope is cut to this angle";
  EXPECT_EQ(result().verdict, ValidationVerdict::not_independent);
  EXPECT_THAT(result().headline, HasSubstr("but the slope is cut to this angle"));
}

TEST_F(Comparisons, KnowDataByTheirContent) {
  const RunGroup base = group(RunGroup::Purpose::base, {10, 10.2, 9.8});
  evidence.base = evidence.numerics_base = &base;
  MaterialRecord record;
  record.name = "ice";
  record.version = 3;
  record.provenance.measurements = {
      {"m", "heap.angle", 10, 0.1, "deg", "a notebook", "heap, 2026"}};
  evidence.material = &record;
  using V = ValidationVerdict;
  what.measurement.response = "angle";
  what.measurement.value = 10.01;
  what.measurement.source = "reworded";
  EXPECT_EQ(result().verdict, V::not_independent);
  what.measurement.experiment = "some other words";
  EXPECT_EQ(result().verdict, V::not_independent);
  // Of another experiment by its own account, and by its value.
  what.measurement.value = 10.2;
  EXPECT_EQ(result().verdict, V::consistent);
  what.measurement.experiment = "Heap (2026)";
  EXPECT_EQ(result().verdict, V::not_independent);
  // The values of the record without the record.
  evidence.material = nullptr;
  EXPECT_EQ(result().verdict, V::consistent);
  evidence.same_values = {&record};
  EXPECT_EQ(result().verdict, V::not_independent);
  EXPECT_THAT(result().headline, HasSubstr("the case has the values of a record: ice@3"));
}

TEST_F(Comparisons, KnowWhatElseWasChosenWithTheData) {
  const RunGroup base = group(RunGroup::Purpose::base, {10, 10.2, 9.8});
  evidence.base = evidence.numerics_base = &base;
  what.measurement.response = "angle";
  Chosen outlet{"the outlet", what.measurement, {"heap"}};
  suite.chosen = {outlet};
  EXPECT_EQ(result().verdict, ValidationVerdict::not_independent);
  EXPECT_THAT(result().headline, HasSubstr("the outlet was chosen with this measurement"));
  suite.chosen[0].experiments = {"another"};
  EXPECT_EQ(result().verdict, ValidationVerdict::consistent);
  // Statements of the same response are the same data, too.
  suite.chosen[0].experiments = {};
  what.kind = ComparisonKind::criteria;
  what.measurement.criteria = {{"larger", "angle", "5", 1, 0, "x"}};
  what.measurement.experiment = suite.chosen[0].with.experiment = "one";
  EXPECT_EQ(result().verdict, ValidationVerdict::not_independent);
}

TEST_F(Comparisons, WithAnotherSimulationAreNamedSo) {
  const RunGroup base = group(RunGroup::Purpose::base, {10, 10.2, 9.8});
  evidence.base = evidence.numerics_base = &base;
  EXPECT_EQ(verdict_words(result()), "consistent");
  what.measurement.simulated = true;
  EXPECT_EQ(verdict_words(result()), "consistent (code-to-code)");
  EXPECT_THAT(result().caveats, testing::Contains(HasSubstr("validates nothing")));
}

TEST_F(Comparisons, DependOnWhatIsAssumed) {
  const RunGroup base = group(RunGroup::Purpose::base, {6, 7, 8, 9, 10, 11});
  const RunGroup light = group(RunGroup::Purpose::variant, {1, 2, 3});
  const RunGroup heavy = group(RunGroup::Purpose::variant, {7, 8, 9});
  const Variant low{"0.1 kg", {{"a.b", "1"}}, {1, 2, 3}, false, true},
      high{"1 kg", {{"a.b", "2"}}, {1, 2, 3}, false, true};
  evidence.base = evidence.numerics_base = &base;
  what.kind = ComparisonKind::criteria;
  what.measurement.criteria = {{"larger", "angle", "5", 1, 0, "x"}};
  evidence.variants = {{&high, &heavy}};
  suite.experiments[0].assumes = {"the length of the chute"};
  EXPECT_EQ(result().verdict, ValidationVerdict::consistent);
  ASSERT_EQ(result().assumptions.size(), 1u);
  EXPECT_FALSE(result().assumptions[0].changes);
  EXPECT_THAT(result().caveats, testing::Contains(HasSubstr("the length of the chute")));
  evidence.variants = {{&high, &heavy}, {&low, &light}};
  const Comparison c = result();
  EXPECT_EQ(c.verdict, ValidationVerdict::inconclusive);
  EXPECT_TRUE(c.assumptions[1].changes);
  EXPECT_THAT(c.headline, HasSubstr("changes with \"0.1 kg\""));
  EXPECT_THAT(c.recommended_action, HasSubstr("0.1 kg"));
  // Of a value it is a part of the uncertainty.
  what.kind = ComparisonKind::value;
  const Comparison v = result();
  EXPECT_EQ(v.value->components.back().name, "0.1 kg");
  EXPECT_NEAR(*v.value->components.back().value, 5 / std::sqrt(3.0), 1e-12);
  what.not_comparable = "the paper gives no length";
  EXPECT_EQ(result().verdict, ValidationVerdict::not_comparable);
  EXPECT_THAT(result().headline, HasSubstr("the paper gives no length"));
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

TEST_F(Comparisons, RefuseAnotherUnitAndAnUnknownResponse) {
  const RunGroup base = group(RunGroup::Purpose::base, {10, 11});
  evidence.base = evidence.numerics_base = &base;
  what.measurement.unit = "rad";
  EXPECT_THAT([&] { result(); }, ThrowsMessage<InputError>(HasSubstr("expected \"deg\"")));
  what.responses = {"ange"};
  EXPECT_THAT([&] { result(); }, ThrowsMessage<InputError>(HasSubstr("one of angle")));
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

TEST_F(Comparisons, OfACurveJudgeByATolerance) {
  what.kind = ComparisonKind::curve;
  const auto runs = [](std::initializer_list<double> slopes) {
    RunGroup g;
    for (const double slope : slopes) {
      g.seeds.push_back(g.seeds.size() + 1);
      g.results.push_back(finished({response("press_curve_x", {0, 1, 2}, "m"),
                                    response("press_curve_y", {0, slope, 2 * slope}, "N")}));
    }
    return g;
  };
  const RunGroup base = runs({10, 10.1, 9.9});
  evidence.base = evidence.numerics_base = &base;
  MeasuredData data;
  data.kind = MeasuredData::Kind::curve;
  data.response = "press";
  data.file = "press.csv";
  data.unit = "N";
  data.x_unit = "m";
  what.measurement.data = data;
  EXPECT_EQ(result().verdict, ValidationVerdict::inconclusive);
  EXPECT_THAT(result().recommended_action, HasSubstr("press.csv"));
  // What the runs have is shown all the same.
  ASSERT_TRUE(result().curve);
  EXPECT_TRUE(result().curve->measured.empty());
  EXPECT_NEAR(result().curve->simulated.back(), 20, 1e-9);
  EXPECT_NEAR(result().curve->simulated_error.back(), 0.2 / std::sqrt(3.0), 1e-9);
  const auto verdict = [&](double slope, std::optional<double> tolerance) {
    data.present = true;
    data.repeats = {{{0, 2}, {0, 2 * slope}}, {{0, 2}, {0, 2.02 * slope}}};
    what.measurement.data = data;
    what.tolerance = tolerance;
    return result().verdict;
  };
  EXPECT_EQ(verdict(10, 0.2), ValidationVerdict::consistent);
  EXPECT_EQ(verdict(20, 0.2), ValidationVerdict::inconsistent);
  EXPECT_EQ(verdict(10, 0.01), ValidationVerdict::inconclusive);
  EXPECT_EQ(verdict(20, {}), ValidationVerdict::not_judged);
  // Most of the difference is no difference of the forces.
  const auto caveats = [&](double shift, double factor, double offset) {
    MeasuredData::Repeat r;
    for (int i = 0; i <= 100; ++i) {
      const double x = 0.02 * i;
      r.x.push_back(x + shift);
      r.y.push_back(factor * 10 * x + offset);
    }
    data.repeats = {r, r};
    what.measurement.data = data;
    std::string all;
    for (const std::string& caveat : result().caveats) all += caveat + "\n";
    return all;
  };
  EXPECT_THAT(caveats(0, 1, 0), Not(HasSubstr("shifted")));
  EXPECT_THAT(caveats(0.6, 1, 0),
              HasSubstr("with the simulation shifted by 0.6 m the difference is 0"));
  EXPECT_THAT(caveats(0, -1, 0), HasSubstr("opposite signs"));
  EXPECT_THAT(caveats(0, 1, 7), HasSubstr("without a constant 7 N the difference is"));
  data.align = MeasuredData::Alignment::best;
  EXPECT_THAT(caveats(0.6, 1, 0), Not(HasSubstr("shifted")));
  data.align = MeasuredData::Alignment::none;
  // The experiment's own units: the simulation is brought to them.
  data.x_unit = "mm";
  data.unit = "kN";
  data.repeats = {{{0, 2000}, {0, 0.020}}, {{0, 2000}, {0, 0.0202}}};
  what.measurement.data = data;
  what.tolerance = 0.2;
  EXPECT_EQ(result().verdict, ValidationVerdict::consistent);
  EXPECT_EQ(result().curve->x_unit, "mm");
  EXPECT_NEAR(result().curve->x.back(), 2000, 1e-9);
  EXPECT_NEAR(result().curve->simulated.back(), 0.020, 1e-12);
  what.measurement.data->x_unit = "s";
  EXPECT_THAT([&] { result(); }, ThrowsMessage<InputError>(HasSubstr("press_curve_x")));
}

TEST_F(Comparisons, OfDamageGiveBoundsAndAnAssumption) {
  what.kind = ComparisonKind::breakage;
  what.responses = {"loads"};
  Measurement& m = what.measurement;
  m.unit = "N";
  m.scatter = ScatterKind::range;
  m.repeats = 7;
  m.value = 1044;
  m.minimum = 898.5;
  m.maximum = 1227.7;
  const auto verdict = [&](const std::vector<double>& loads) {
    RunGroup base;
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      base.seeds.push_back(seed);
      base.results.push_back(finished({response("loads", loads, "N")}));
    }
    evidence.base = evidence.numerics_base = &base;
    const Comparison c = result();
    EXPECT_EQ(c.breakage.at(0).particles, 3 * static_cast<int>(loads.size()));
    return c.verdict;
  };
  EXPECT_EQ(verdict({2000, 10}), ValidationVerdict::consistent);
  // Seven tests do not show that nothing weaker exists.
  EXPECT_EQ(verdict({300, 10}), ValidationVerdict::inconclusive);
  what.expects_breakage = false;
  EXPECT_EQ(verdict({2000, 10}), ValidationVerdict::inconsistent);
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

TEST(ResponseExpression, ReadsNumbersNamesElementsAndSummaries) {
  const std::vector<Response> r = {response("counts", {3, NAN, 5, 4}, "1"),
                                   response("time", {2}, "s")};
  const auto value = [&](const char* text) { return evaluate(parse_response_expression(text), r); };
  EXPECT_EQ(value("-2.5"), -2.5);
  EXPECT_EQ(value("time"), 2);
  EXPECT_EQ(value("counts[3]"), 5);
  EXPECT_TRUE(std::isnan(value("counts[2]")));
  EXPECT_TRUE(std::isnan(value("counts[9]")));
  EXPECT_EQ(value("max counts"), 5);
  EXPECT_EQ(value("min counts"), 3);
  EXPECT_EQ(value("sum counts"), 12);
  EXPECT_EQ(value("mean counts"), 4);
  EXPECT_EQ(value("median counts"), 4);
  EXPECT_THROW(value("counts"), InputError);
  for (const char* wrong : {"", "a b", "counts[0]", "counts[x]", "counts[2", "largest time"})
    EXPECT_THROW(parse_response_expression(wrong), InputError) << wrong;
}

}  // namespace
}  // namespace firn
