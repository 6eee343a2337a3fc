// Data that cannot validate: those that parameters or the case were fitted to, and those that
// depend on what is assumed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/validation/comparison/compared_runs.h"

namespace firn {
namespace {

using namespace test;
using testing::HasSubstr;

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

}  // namespace
}  // namespace firn
