#include "validation/suite/suite_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>

#include "experiments/batch/execution/execution_settings.h"
#include "experiments/responses/response_expression.h"
#include "experiments/system/input_file.h"
#include "experiments/system/input_limits.h"
#include "experiments/text/toml_document.h"
#include "experiments/text/toml_names.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
constexpr int most_seeds = 10000;

struct Seeds {
  int count = 3, first = 1;
};

std::string relative_to(const Suite& suite, const std::string& file) {
  return (fs::path(suite.source).parent_path() / file).lexically_normal().string();
}

// Throws for a file that is not there. `wanted`: "a case file".
void require_file(const TomlTable& t, std::string_view key, const std::string& file,
                  const char* wanted) {
  std::error_code unreadable;  // as a name that is too long
  const char* fault = !fs::exists(file, unreadable)        ? "does not exist"
                      : fs::is_directory(file, unreadable) ? "is a folder"
                                                           : nullptr;
  if (fault != nullptr)
    t.fail(key, fmt::format("{} {}; expected {}, relative to the suite", file, fault, wanted));
}

Measurement measurement_of_case(const TomlTable& t, const Suite& suite) {
  const std::string file = relative_to(suite, t.string("measurement"));
  require_file(t, "measurement", file, "a measurement file");
  Measurement m = read_measurement(file);
  use_current_responses(m);
  return m;
}

ParameterSet read_parameter_set(const TomlTable& t, const Suite& suite) {
  t.allow({"name", "note", "material", "set", "samples"});
  ParameterSet p;
  p.name = unique_table_name(t, suite.parameter_sets);
  p.note = t.string("note", "");
  p.material = t.string("material", "");
  p.material_place = t.place("material");
  p.set = read_case_overrides(t, &p.set_places);
  p.samples = t.integer("samples", 0, 0);
  p.samples_place = t.place("samples");
  if (p.samples > 0 && p.material.empty())
    t.fail("samples",
           "without a material has no posterior ensemble to draw from; expected a material");
  return p;
}

int read_seeds(const TomlTable& t, int fallback) {
  const int count = t.integer("seeds", 1, fallback);
  if (count > most_seeds)
    t.fail("seeds", fmt::format("are more than {}; expected fewer", most_seeds));
  return count;
}

// One factor, or several of which each is the same part of the one before.
std::vector<double> read_factors(const TomlTable& t) {
  constexpr const char* key = "timestep";
  constexpr double even = 1e-6;
  std::vector<double> factors;
  if (!t.has(key)) return factors;
  if (!t.is_list(key)) {
    factors = {t.number(key)};
    if (factors[0] == 0) return {};
  } else {
    for (const std::string& text : t.value_texts(key)) {
      double factor = 0;
      const auto end = text.data() + text.size();
      if (std::from_chars(text.data(), end, factor).ptr != end)
        t.fail_element(key, factors.size(),
                       fmt::format("has the entry {}; expected factors between 0 and 1", text));
      factors.push_back(factor);
    }
    if (factors.empty()) t.fail(key, "is empty; expected factors, such as [0.5, 0.25]");
  }
  double before = 1;
  for (std::size_t i = 0; i < factors.size(); ++i) {
    const double f = factors[i];
    if (!(f > 0 && f < before))
      t.fail_element(
          key, i,
          fmt::format("has the factor {} after {}; expected factors between 0 and 1, each "
                      "smaller than the one before, such as 0.5",
                      f, before));
    if (std::abs(f / before - factors[0]) > even)
      t.fail_element(
          key, i, fmt::format("has steps of different ratios; expected powers of {}", factors[0]));
    before = f;
  }
  return factors;
}

Refinement read_refinement(const TomlTable& t, const Seeds& seeds) {
  t.allow({"timestep", "stiffness", "material", "seeds"});
  Refinement r;
  r.timesteps = read_factors(t);
  if (!r.timesteps.empty()) r.timestep_places = t.element_places("timestep");
  if (t.has("stiffness")) {
    r.stiffness = t.quantities("stiffness", dimension::pressure);
    r.stiffness_places = t.element_places("stiffness");
    r.material = t.string("material");
    r.material_place = t.place("material");
  }
  for (std::size_t i = 0; i < r.stiffness.size(); ++i)
    if (!(r.stiffness[i] > 0))
      t.fail_element("stiffness", i, "is not above zero; expected Young's moduli");
  r.seeds = seed_list(seeds.first, read_seeds(t, std::min(3, seeds.count)));
  return r;
}

Variant read_variant(const TomlTable& t, const std::vector<Variant>& others, const Seeds& seeds) {
  t.allow({"name", "set", "seeds", "numerics", "assumed"});
  Variant v;
  v.name = unique_table_name(t, others);
  v.set = read_case_overrides(t, &v.set_places);
  if (v.set.empty())
    t.fail("set", "is missing; expected what differs, such as { \"case.timestep\" = \"5 us\" }");
  v.seeds = seed_list(seeds.first, read_seeds(t, std::min(3, seeds.count)));
  v.assumed = t.boolean("assumed", false);
  v.numerics = t.boolean("numerics", !v.assumed);
  if (v.assumed && v.numerics)
    t.fail("numerics", "does not go with `assumed`; expected one of the two");
  return v;
}

[[noreturn]] void too_many_runs(const TomlTable& t, std::string_view key) {
  t.fail(key, fmt::format("make more than {} runs; expected fewer", input_limits::batch_runs));
}

SuiteExperiment read_experiment(const TomlTable& t, const Suite& suite, const Seeds& of_suite) {
  t.allow({"name", "case", "set", "seeds", "samples", "parameter_sets", "refine", "variants",
           "assumes"});
  SuiteExperiment e;
  e.name = unique_table_name(t, suite.experiments);
  e.case_file = relative_to(suite, t.string("case"));
  require_file(t, "case", e.case_file, "a case file");
  e.set = read_case_overrides(t, &e.set_places);
  Seeds seeds = of_suite;
  seeds.count = read_seeds(t, of_suite.count);
  e.seeds = seed_list(seeds.first, seeds.count);
  if (t.has("samples")) {
    e.samples = t.integer("samples", 0);
    e.samples_place = t.place("samples");
  }
  e.assumes = t.strings("assumes");
  for (const std::string& name : t.strings("parameter_sets")) {
    if (std::ranges::find(suite.parameter_sets, name, &ParameterSet::name) ==
        suite.parameter_sets.end())
      t.fail_element(
          "parameter_sets", e.parameter_sets.size(),
          fmt::format("\"{}\" is none of the suite's; expected names of [[parameter_sets]]", name));
    e.parameter_sets.push_back(name);
  }
  if (t.has("refine")) e.refine = read_refinement(t.required_table("refine"), seeds);
  std::size_t of_variants = 0;
  for (const TomlTable& v : t.tables("variants")) {
    e.variants.push_back(read_variant(v, e.variants, seeds));
    of_variants += e.variants.back().seeds.size();
    if (of_variants > input_limits::batch_runs) too_many_runs(t, "variants");
  }
  return e;
}

// Runs of an experiment, but for those that samples of an ensemble take the place of.
std::size_t runs_of(const SuiteExperiment& e, const Suite& suite) {
  std::size_t runs =
      (e.refine.timesteps.size() + e.refine.stiffness.size()) * e.refine.seeds.size();
  for (const Variant& v : e.variants) runs += v.seeds.size();
  for (const ParameterSet& set : suite.parameter_sets)
    if (e.runs_with(set))
      runs += e.seeds.size() + static_cast<std::size_t>(e.samples.value_or(set.samples));
  return runs;
}

Chosen read_chosen(const TomlTable& t, const Suite& suite) {
  t.allow({"what", "measurement", "experiments"});
  Chosen c;
  c.what = t.string("what");
  if (c.what.empty()) t.fail("what", "is empty; expected what was chosen, in words");
  c.with = measurement_of_case(t, suite);
  c.experiments = t.strings("experiments");
  for (std::size_t i = 0; i < c.experiments.size(); ++i)
    if (std::ranges::find(suite.experiments, c.experiments[i], &SuiteExperiment::name) ==
        suite.experiments.end())
      t.fail_element(
          "experiments", i,
          fmt::format(
              "\"{}\" is not an experiment of this suite; expected names of [[experiments]]",
              c.experiments[i]));
  return c;
}

ComparisonKind read_kind(const TomlTable& t) {
  const std::string kind = t.choice("kind", {"value", "curve", "criteria", "breakage",
                                             "stiffness_scaling", "numerical_variants"});
  for (const auto k : {ComparisonKind::value, ComparisonKind::curve, ComparisonKind::criteria,
                       ComparisonKind::breakage, ComparisonKind::stiffness_scaling})
    if (kind == to_string(k)) return k;
  return ComparisonKind::numerical_variants;
}

void read_value(const TomlTable& t, SuiteComparison& c) {
  if (c.measurement.status == MeasurementStatus::qualitative)
    t.fail("measurement", "is qualitative; expected one with a value, or the kind \"criteria\"");
  c.response_places = {t.has("response") ? t.place("response") : c.measurement.response_place};
  c.responses = {current_response(t, "response", t.string("response", c.measurement.response))};
  c.calibrated_by_design = t.string("calibrated_by_design", "");
  if (!t.has("tolerance")) return;
  const std::string text = t.string("tolerance");
  const UnitValue q = t.at("tolerance", [&] { return parse_unit_value(text); });
  if (q.unit != c.measurement.unit || !(q.value > 0))
    t.fail("tolerance", fmt::format("is {}; expected an amount above zero in \"{}\", the unit of "
                                    "the measurement",
                                    text, c.measurement.unit));
  c.tolerance = q.value;
}

void read_operands(const TomlTable& t, SuiteComparison& c) {
  c.responses = current_responses(t, "responses");
  if (c.responses.empty())
    t.fail("responses", "is missing; expected names of responses, such as [\"compressive_loads\"]");
  for (std::size_t i = 0; i < c.responses.size(); ++i)
    t.at_element("responses", i, [&] { parse_response_expression(c.responses[i]); });
  for (const ValuePlace& place : t.element_places("responses"))
    c.response_places.push_back(place.whole);
}

// A share of the measured range.
void read_curve(const TomlTable& t, SuiteComparison& c) {
  if (!c.measurement.data || c.measurement.data->kind != MeasuredData::Kind::curve)
    t.fail("measurement", "has no [data] of the kind \"curve\"; expected one that has");
  if (t.has("tolerance")) c.tolerance = t.number("tolerance", 0);
  if (c.tolerance && !(*c.tolerance > 0))
    t.fail("tolerance", "is not above zero; expected a share of the measured range");
}

void check_criteria(const TomlTable& t, const SuiteComparison& c) {
  if (c.measurement.criteria.empty())
    t.fail("measurement", "has no [[criteria]]; expected a qualitative measurement with criteria");
  for (const Criterion& criterion : c.measurement.criteria) {
    with_place(criterion.lhs_place, [&] { parse_response_expression(criterion.lhs); });
    with_place(criterion.rhs_place, [&] { parse_response_expression(criterion.rhs); });
  }
}

void read_stiffness_scaling(const TomlTable& t, const SuiteExperiment& experiment,
                            SuiteComparison& c) {
  read_operands(t, c);
  c.real_modulus = t.quantity("real_modulus", dimension::pressure, Sign::positive);
  if (experiment.refine.stiffness.empty())
    t.fail("experiment", fmt::format("\"{}\" is simulated with one stiffness only; expected "
                                     "refine.stiffness there",
                                     experiment.name));
}

void read_numerical_variants(const TomlTable& t, const SuiteExperiment& experiment,
                             SuiteComparison& c) {
  read_operands(t, c);
  if (experiment.refine.stiffness.empty() && experiment.refine.timesteps.empty() &&
      experiment.variants.empty())
    t.fail("experiment", fmt::format("\"{}\" is simulated in one way only; expected refine or "
                                     "variants there",
                                     experiment.name));
}

// Throws for a key that belongs to comparisons of other kinds.
void require_keys_of_kind(const TomlTable& t, ComparisonKind kind) {
  const auto belongs = [&](const char* key, bool here) {
    if (t.has(key) && !here)
      t.fail(key, fmt::format("does not go with the kind \"{}\"; expected it left out",
                              to_string(kind)));
  };
  const bool breakage = kind == ComparisonKind::breakage;
  belongs("response", kind == ComparisonKind::value);
  belongs("calibrated_by_design", kind == ComparisonKind::value);
  belongs("not_comparable", measures(kind));
  belongs("tolerance", kind == ComparisonKind::value || kind == ComparisonKind::curve);
  belongs("responses", breakage || !measures(kind));
  belongs("expected_outcome", breakage);
  belongs("real_modulus", kind == ComparisonKind::stiffness_scaling);
  belongs("measurement", measures(kind));
}

SuiteComparison read_comparison(const TomlTable& t, const Suite& suite) {
  t.allow({"name", "title", "note", "kind", "experiment", "measurement", "response", "responses",
           "tolerance", "calibrated_by_design", "not_comparable", "expected_outcome",
           "real_modulus"});
  SuiteComparison c;
  c.name = unique_table_name(t, suite.comparisons);
  c.title = t.string("title", c.name);
  c.note = t.string("note", "");
  c.kind = read_kind(t);
  const std::string experiment = t.string("experiment");
  const auto found = std::ranges::find(suite.experiments, experiment, &SuiteExperiment::name);
  if (found == suite.experiments.end())
    t.fail("experiment",
           fmt::format("\"{}\" is not an experiment of this suite; expected the name of "
                       "one",
                       experiment));
  c.experiment = static_cast<std::size_t>(found - suite.experiments.begin());
  require_keys_of_kind(t, c.kind);
  c.not_comparable = t.string("not_comparable", "");
  if (measures(c.kind)) c.measurement = measurement_of_case(t, suite);
  switch (c.kind) {
    case ComparisonKind::value:
      read_value(t, c);
      break;
    case ComparisonKind::curve:
      read_curve(t, c);
      break;
    case ComparisonKind::criteria:
      check_criteria(t, c);
      break;
    case ComparisonKind::breakage:
      read_operands(t, c);
      c.expects_breakage =
          t.choice("expected_outcome", {"breakage", "no breakage"}, "breakage") == "breakage";
      break;
    case ComparisonKind::stiffness_scaling:
      read_stiffness_scaling(t, *found, c);
      break;
    case ComparisonKind::numerical_variants:
      read_numerical_variants(t, *found, c);
      break;
  }
  return c;
}

}  // namespace

const char* to_string(ComparisonKind kind) {
  switch (kind) {
    case ComparisonKind::value:
      return "value";
    case ComparisonKind::curve:
      return "curve";
    case ComparisonKind::criteria:
      return "criteria";
    case ComparisonKind::breakage:
      return "breakage";
    case ComparisonKind::stiffness_scaling:
      return "stiffness_scaling";
    case ComparisonKind::numerical_variants:
      return "numerical_variants";
  }
  return "";
}

bool SuiteExperiment::runs_with(const ParameterSet& set) const {
  return parameter_sets.empty() || std::ranges::count(parameter_sets, set.name) > 0;
}

bool Chosen::belongs_to(const SuiteExperiment& experiment) const {
  return experiments.empty() || std::ranges::count(experiments, experiment.name) > 0;
}

bool measures(ComparisonKind kind) {
  return kind != ComparisonKind::stiffness_scaling && kind != ComparisonKind::numerical_variants;
}

Suite read_suite(const std::string& file) {
  Suite suite;
  suite.source = file;
  suite.text = read_input_file(file, "a suite file", input_limits::toml_bytes);
  TomlDocument document(suite.text, file, TomlFormat::suite);
  require_kind(document, "suite");
  const TomlTable root = TomlTable::root(document);
  root.allow({"suite", "execution", "parameter_sets", "experiments", "chosen", "comparisons"});
  const TomlTable head = root.required_table("suite");
  head.allow({"name", "title", "note", "seeds", "first_seed", "threads"});
  suite.name = valid_name(head);
  suite.title = head.string("title", suite.name);
  suite.note = head.string("note", "");
  suite.threads = head.integer("threads", 1, 1);
  const Seeds seeds{read_seeds(head, 3), head.integer("first_seed", 1, 1)};
  for (const TomlTable& t : root.tables("parameter_sets"))
    suite.parameter_sets.push_back(read_parameter_set(t, suite));
  if (suite.parameter_sets.empty())
    suite.parameter_sets.push_back({"as the cases say", "", "", {}, 0});
  std::size_t runs = 0;
  for (const TomlTable& t : root.tables("experiments")) {
    suite.experiments.push_back(read_experiment(t, suite, seeds));
    runs += runs_of(suite.experiments.back(), suite);
    if (runs > input_limits::batch_runs) too_many_runs(root, "experiments");
  }
  for (const TomlTable& t : root.tables("chosen")) suite.chosen.push_back(read_chosen(t, suite));
  for (const TomlTable& t : root.tables("comparisons"))
    suite.comparisons.push_back(read_comparison(t, suite));
  if (suite.comparisons.empty())
    root.fail("comparisons", "is missing; expected at least one [[comparisons]] table");
  suite.execution = read_execution(root);
  return suite;
}

}  // namespace firn
