// Curves, and loads that may break particles.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/validation/comparison/compared_runs.h"

namespace firn {
namespace {

using namespace test;
using testing::HasSubstr;
using testing::Not;
using testing::ThrowsMessage;

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

}  // namespace
}  // namespace firn
