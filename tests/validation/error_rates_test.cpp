// How often each validator rejects a simulation that is right, and one that is wrong, on synthetic
// suites. The long tier takes 1000 suites for each number of data and prints the table of
// docs/validation.md.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <iostream>
#include <ostream>
#include <random>

#include "experiments/analysis/random_stream.h"
#include "validation/comparison/comparison.h"

namespace firn {
namespace {

constexpr double level = 0.05;

struct Dice {
  std::mt19937_64 bits;
  double uniform() { return uniform_open(bits); }
  double normal() { return normal_deviate(bits); }
};

using Values = std::vector<double>;

Values sample(int n, const std::function<double()>& draw) {
  Values v;
  for (int i = 0; i < n; ++i) v.push_back(draw());
  return v;
}

JobResult run_with(std::vector<Response> responses) {
  JobResult r;
  r.status = JobStatus::finished;
  r.responses = std::move(responses);
  return r;
}

RunGroup runs_of(std::size_t n, RunGroup::Purpose purpose,
                 const std::function<std::vector<Response>()>& run) {
  RunGroup g;
  g.purpose = purpose;
  for (std::size_t i = 0; i < n; ++i) {
    g.seeds.push_back(i + 1);
    g.results.push_back(run_with(run()));
  }
  return g;
}

Measurement measured(const Values& values) {
  Measurement m;
  m.unit = "N";
  m.values = values;
  m.scatter = ScatterKind::values;
  const SampleStatistics f = sample_statistics(values);
  m.value = f.mean;
  m.standard_deviation = f.deviation;
  m.repeats = f.count;
  m.minimum = *std::ranges::min_element(values);
  m.maximum = *std::ranges::max_element(values);
  return m;
}

Comparison judge(SuiteComparison what, const ComparisonRuns& evidence) {
  Suite suite;
  suite.experiments.push_back({"experiment", "", {}, {1}, {}});
  return compare(suite, what, {}, evidence);
}

Comparison judge(SuiteComparison what, const RunGroup& base) {
  ComparisonRuns e;
  e.base = e.numerics_base = &base;
  return judge(std::move(what), e);
}

// A claim that holds always, so that the data decide.
Measurement with_data(MeasuredData data) {
  Measurement m;
  m.criteria = {{"", "1", "0", 1, 0, ""}};
  data.present = true;
  m.data = std::move(data);
  return m;
}

enum class Truth { right, wrong };
using V = ValidationVerdict;

V distribution_verdict(const MeasuredData& data, const RunGroup& base) {
  SuiteComparison what;
  what.kind = ComparisonKind::criteria;
  what.measurement = with_data(data);
  return judge(what, base).distribution->verdict;
}

// --- the validators: each makes one suite with n data and gives its verdict ---

V value_of_seeds(Dice& d, int n, Truth truth) {
  SuiteComparison what;
  what.responses = {"x"};
  const double mean = truth == Truth::right ? 100 : 100 + 15;
  const auto size = static_cast<std::size_t>(n);
  const RunGroup base = runs_of(size, RunGroup::Purpose::base, [&] {
    return std::vector<Response>{{"x", {mean + 10 * d.normal()}, {}, "N", "", 1}};
  });
  what.measurement = measured(sample(n, [&] { return 100 + 10 * d.normal(); }));
  return judge(what, base).verdict;
}

// n draws from a family whose scatter is `input`, five seeds of scatter 10.
V value_of_draws(Dice& d, int n, Truth truth, double input) {
  SuiteComparison what;
  what.responses = {"x"};
  const auto response = [](double x) { return std::vector<Response>{{"x", {x}, {}, "N", "", 1}}; };
  const RunGroup base =
      runs_of(5, RunGroup::Purpose::base, [&] { return response(1000 + 10 * d.normal()); });
  const RunGroup draws = runs_of(static_cast<std::size_t>(n), RunGroup::Purpose::input, [&] {
    return response(1000 + 10 * d.normal() + input * d.normal());
  });
  const double real =
      1000 + (truth == Truth::right ? input * d.normal() : 3 * std::hypot(10, input));
  what.measurement = measured(sample(30, [&] { return real + 5 * d.normal(); }));
  ComparisonRuns e;
  e.base = e.numerics_base = &base;
  e.input = &draws;
  return judge(what, e).verdict;
}

// Of n runs those with a large value are missing, as runs of a machine that jams.
V value_with_missing(Dice& d, int n, Truth truth) {
  SuiteComparison what;
  what.responses = {"x"};
  const double mean = truth == Truth::right ? 100 : 100 + 15;
  RunGroup base = runs_of(static_cast<std::size_t>(n), RunGroup::Purpose::base, [&] {
    return std::vector<Response>{{"x", {mean + 10 * d.normal()}, {}, "N", "", 1}};
  });
  for (JobResult& r : base.results)
    if (r.responses[0].value[0] > mean + 5) r.status = JobStatus::failed;
  what.measurement = measured(sample(n, [&] { return 100 + 10 * d.normal(); }));
  return judge(what, base).verdict;
}

// A statement that holds in half of the runs, or in a tenth. A quarter of those in which it holds
// fail.
V criteria_with_missing(Dice& d, int n, Truth truth) {
  SuiteComparison what;
  what.kind = ComparisonKind::criteria;
  what.measurement.criteria = {{"", "x", "0", 1, 0, ""}};
  const double holds = truth == Truth::right ? 0.5 : 0.1;
  RunGroup base = runs_of(static_cast<std::size_t>(n), RunGroup::Purpose::base, [&] {
    return std::vector<Response>{{"x", {d.uniform() < holds ? 1.0 : -1.0}, {}, "1", "", 1}};
  });
  for (JobResult& r : base.results)
    if (r.responses[0].value[0] > 0 && d.uniform() < 0.25) r.status = JobStatus::failed;
  return judge(what, base).verdict;
}

// `claims` statements of which each holds in half of the runs, or in a tenth.
V criteria(Dice& d, int n, Truth truth, int criteria) {
  SuiteComparison what;
  what.kind = ComparisonKind::criteria;
  std::vector<std::string> names;
  for (int k = 0; k < criteria; ++k) {
    names.push_back("x" + std::to_string(k));
    what.measurement.criteria.push_back({"", names.back(), "0", 1, 0, ""});
  }
  const double holds = truth == Truth::right ? 0.5 : 0.1;
  const RunGroup base = runs_of(static_cast<std::size_t>(n), RunGroup::Purpose::base, [&] {
    std::vector<Response> r;
    for (const std::string& name : names)
      r.push_back({name, {d.uniform() < holds ? 1.0 : -1.0}, {}, "1", "", 1});
    return r;
  });
  return judge(what, base).verdict;
}

enum class Family { normal, exponential, lognormal };
double draw(Dice& d, Family family) {
  if (family == Family::normal) return 10 + 3 * d.normal();
  if (family == Family::exponential) return -10 * std::log(d.uniform());
  return 10 * std::exp(0.5 * d.normal());
}

// n measured values, and five runs of n: the values of a run share a part of their scatter.
struct Samples {
  RunGroup base;
  MeasuredData data;
};
Samples samples(Dice& d, int n, Family family, double factor, double common) {
  const auto one_run = [&] {
    const double shared = std::exp(common * d.normal());
    return sample(n, [&] { return shared * draw(d, family); });
  };
  Samples s;
  s.base = runs_of(5, RunGroup::Purpose::base, [&] {
    return std::vector<Response>{{"x", one_run(), {}, "N", "", 1}};
  });
  s.data.response = "x";
  s.data.unit = "N";
  s.data.values = one_run();
  for (double& v : s.data.values) v *= factor;
  return s;
}
V distribution(Dice& d, int n, Truth truth, Family family, double common) {
  const Samples s = samples(d, n, family, truth == Truth::right ? 1 : 2, common);
  return distribution_verdict(s.data, s.base);
}
// One measured value in a right suite is ten times too large.
V outlier(Dice& d, int n, Truth truth, Family family) {
  Samples s = samples(d, n, family, 1, 0);
  if (truth == Truth::wrong) s.data.values.back() *= 10;
  return distribution_verdict(s.data, s.base);
}

// Five runs watched for 15 s, the experiment for 25 s.
V open_times(Dice& d, int n, Truth truth) {
  const auto watch = [&](double mean, double end) {
    std::array<Values, 2> all;  // passed, inside
    for (int i = 0; i < n; ++i) {
      const double t = -mean * std::log(d.uniform());
      all[t < end ? 0 : 1].push_back(std::min(t, end));
    }
    return all;
  };
  const RunGroup base = runs_of(5, RunGroup::Purpose::base, [&] {
    const auto [passed, inside] = watch(10, 15);
    return std::vector<Response>{{"a_residence_times", passed, {}, "s", "", 1},
                                 {"a_censored_times", inside, {}, "s", "", 1}};
  });
  MeasuredData data;
  data.response = "a_residence_times";
  data.unit = "s";
  const auto [passed, inside] = watch(truth == Truth::right ? 10 : 25, 25);
  data.values = passed;
  data.right_censored = inside;
  return distribution_verdict(data, base);
}

// n things in five classes, and five runs of n. `clump` things in succession are of one class.
V classes(Dice& d, int n, Truth truth, int clump) {
  const auto count = [&](const std::array<double, 5>& share) {
    Values counts(5, 0);
    for (int i = 0; i < n;) {
      double r = d.uniform();
      std::size_t k = 0;
      while (k < 4 && r >= share[k]) r -= share[k++];
      for (int c = 0; c < clump && i < n; ++c, ++i) counts[k] += 1;
    }
    return counts;
  };
  const std::array<double, 5> share = {0.05, 0.15, 0.2, 0.3, 0.3},
                              other = {0.3, 0.3, 0.2, 0.15, 0.05};
  const RunGroup base = runs_of(5, RunGroup::Purpose::base, [&] {
    return std::vector<Response>{{"n", count(share), {}, "1", "", 1}};
  });
  MeasuredData data;
  data.kind = MeasuredData::Kind::classes;
  data.response = "n";
  data.classes = {"1", "2", "3", "4", "5"};
  data.counts = count(truth == Truth::right ? share : other);
  return distribution_verdict(data, base);
}

// n runs and `repeats` measured curves (0: n), each off by a constant of scatter 10 %.
V curves(Dice& d, int n, Truth truth, int repeats) {
  SuiteComparison what;
  what.kind = ComparisonKind::curve;
  what.tolerance = 1e-6;
  const auto line = [&](double by) {
    Values y;
    for (int i = 0; i <= 20; ++i) y.push_back(i / 20.0 + by);
    return y;
  };
  Values x;
  for (int i = 0; i <= 20; ++i) x.push_back(i / 20.0);
  const RunGroup base = runs_of(static_cast<std::size_t>(n), RunGroup::Purpose::base, [&] {
    return std::vector<Response>{{"c_curve_x", x, {}, "m", "", 1},
                                 {"c_curve_y", line(0.1 * d.normal()), {}, "N", "", 1}};
  });
  MeasuredData data;
  data.kind = MeasuredData::Kind::curve;
  data.present = true;
  data.response = "c";
  data.unit = "N";
  data.x_unit = "m";
  for (int k = 0; k < (repeats > 0 ? repeats : n); ++k)
    data.repeats.push_back({x, line(0.1 * d.normal() + (truth == Truth::right ? 0 : 0.3))});
  what.measurement.data = data;
  return judge(what, base).verdict;
}

// n breaking tests, Weibull with the shape 8, and runs of five particles whose loads make damage of
// at least one as improbable (5 %) as the verdict allows; or 5 % too strong for the statement.
V damage(Dice& d, int n, Truth truth, bool expects) {
  SuiteComparison what;
  what.kind = ComparisonKind::breakage;
  what.responses = {"loads"};
  what.expects_breakage = expects;
  const double shape = 8, scale = 1000;
  what.measurement =
      measured(sample(n, [&] { return scale * std::pow(-std::log(d.uniform()), 1 / shape); }));
  const double each = truth == Truth::right ? 1 - std::pow(1 - level, 0.2) : (expects ? 0 : 0.9);
  const double load = scale * std::pow(-std::log1p(-each), 1 / shape);
  const RunGroup base = runs_of(5, RunGroup::Purpose::base, [&] {
    return std::vector<Response>{{"loads", Values(5, load), {}, "N", "", 1}};
  });
  return judge(what, base).verdict;
}

// --- rates ---

struct Rates {
  double rejected = 0, open = 0, passed = 0;
};
using Validator = std::function<V(Dice&, int, Truth)>;

Rates rates(const Validator& validator, int n, Truth truth, int suites) {
  Dice dice{std::mt19937_64(static_cast<std::uint64_t>(1000 * n + (truth == Truth::right)))};
  Rates r;
  for (int i = 0; i < suites; ++i) {
    const V v = validator(dice, n, truth);
    (v == V::inconsistent ? r.rejected : v == V::consistent ? r.passed : r.open) += 1.0 / suites;
  }
  return r;
}

struct Row {
  const char* name;
  Validator validator;
  bool exact;  // the level is 5 %; else at most 5 %
};

std::vector<Row> all_validators() {
  return {
      {"value: n runs, n repeats", value_of_seeds, true},
      {"value: n draws, input 3 times seeds",
       [](Dice& d, int n, Truth t) { return value_of_draws(d, n, t, 30); }, true},
      {"value: n draws, input as seeds",
       [](Dice& d, int n, Truth t) { return value_of_draws(d, n, t, 10); }, false},
      {"claims: one, n runs", [](Dice& d, int n, Truth t) { return criteria(d, n, t, 1); }, false},
      {"claims: five, n runs", [](Dice& d, int n, Truth t) { return criteria(d, n, t, 5); }, false},
      {"value: large values are missing", value_with_missing, false},
      {"claims: one, runs are missing", criteria_with_missing, false},
      {"distribution: normal",
       [](Dice& d, int n, Truth t) { return distribution(d, n, t, Family::normal, 0); }, false},
      {"distribution: exponential",
       [](Dice& d, int n, Truth t) { return distribution(d, n, t, Family::exponential, 0); },
       false},
      {"distribution: lognormal",
       [](Dice& d, int n, Truth t) { return distribution(d, n, t, Family::lognormal, 0); }, false},
      {"distribution: runs differ",
       [](Dice& d, int n, Truth t) { return distribution(d, n, t, Family::lognormal, 0.3); },
       false},
      {"distribution: a value x 10",
       [](Dice& d, int n, Truth t) { return outlier(d, n, t, Family::normal); }, false},
      {"open times", open_times, false},
      {"classes: multinomial", [](Dice& d, int n, Truth t) { return classes(d, n, t, 1); }, false},
      {"classes: clumps of four", [](Dice& d, int n, Truth t) { return classes(d, n, t, 4); },
       false},
      {"curve: n runs, n repeats", [](Dice& d, int n, Truth t) { return curves(d, n, t, 0); },
       true},
      {"curve: n runs, one repeat", [](Dice& d, int n, Truth t) { return curves(d, n, t, 1); },
       true},
      {"damage: stated", [](Dice& d, int n, Truth t) { return damage(d, n, t, true); }, false},
      {"damage: excluded", [](Dice& d, int n, Truth t) { return damage(d, n, t, false); }, false},
  };
}

// Rates of 1000 suites scatter by 0.7 %, of fewer by more.
void expect_level(const Row& row, const std::vector<int>& numbers, int suites) {
  const double scatter = std::sqrt(level * (1 - level) / suites);
  double sum = 0, many = 0, all_many = 0;
  for (const int n : numbers) {
    const Rates right = rates(row.validator, n, Truth::right, suites);
    const Rates wrong = rates(row.validator, n, Truth::wrong, suites);
    std::cout << fmt::format("| {} | {} | {:.1f} | {:.0f} | {:.0f} | {:.0f} |\n", row.name, n,
                             100 * right.rejected, 100 * right.passed, 100 * wrong.rejected,
                             100 * wrong.passed);
    EXPECT_LE(right.rejected, level + 3.5 * scatter) << row.name << ", n = " << n;
    sum += right.rejected;
    if (n < 10) continue;
    many += right.rejected;
    ++all_many;
  }
  const double mean = sum / static_cast<double>(numbers.size());
  const double margin = 0.015 + 2 * scatter / std::sqrt(static_cast<double>(numbers.size()));
  EXPECT_LE(mean, level + margin) << row.name;
  // Two variances of a few degrees of freedom each make a test of less than its level.
  if (row.exact) {
    EXPECT_GE(many / all_many, level - 0.015 - 2 * scatter / std::sqrt(all_many)) << row.name;
  }
}

TEST(VerdictLevel, IsHeldByEachValidator) {
  for (const Row& row : all_validators()) expect_level(row, {3, 12}, 60);
}

void PrintTo(const Row& row, std::ostream* out) { *out << row.name; }

class VerdictLevelLong : public ::testing::TestWithParam<Row> {};
TEST_P(VerdictLevelLong, IsHeldForAnyNumberOfData) {
  std::cout << "| validator | n | false alarms, % | right passes, % | wrong rejected, % | wrong "
               "passes, % |\n";
  expect_level(GetParam(), {2, 3, 5, 10, 20, 50}, 1000);
}
INSTANTIATE_TEST_SUITE_P(Each, VerdictLevelLong, ::testing::ValuesIn(all_validators()));

TEST(VerdictPower, LetsNoValueThatIsTenTimesTooLargePass) {
  for (const int n : {5, 8, 20, 50})
    for (const Family family : {Family::normal, Family::lognormal}) {
      int passed = 0;
      Dice d{std::mt19937_64(static_cast<std::uint64_t>(n))};
      for (int i = 0; i < 40; ++i) passed += outlier(d, n, Truth::wrong, family) == V::consistent;
      // A small lognormal value times ten may be one that occurs: 4.6 standard deviations, less its
      // own, where 3.8 stand out.
      EXPECT_LE(passed, family == Family::normal ? 1 : 14) << n;
    }
}

}  // namespace
}  // namespace firn
