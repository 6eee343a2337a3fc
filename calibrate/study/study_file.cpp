#include "calibrate/study/study_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "calibrate/study/budget.h"
#include "experiments/measurements/bench_tests.h"
#include "experiments/measurements/measurement.h"
#include "experiments/system/input_file.h"
#include "experiments/system/input_limits.h"
#include "experiments/text/toml_document.h"
#include "experiments/text/toml_names.h"
#include "experiments/text/units.h"

namespace firn {
namespace {

// A number with what stands behind it: bare, or "2.4 in".
struct Quantity {
  double value = 0;
  std::string unit;
};

Quantity split_quantity(const std::string& text) {
  std::size_t used = 0;
  Quantity q;
  try {
    q.value = std::stod(text, &used);
  } catch (const std::exception&) {
    throw InputError(
        fmt::format("\"{}\" is no number; expected a number and its unit, such as "
                    "\"10 deg\"",
                    text));
  }
  const std::size_t unit = text.find_first_not_of(' ', used);
  q.unit = unit == std::string::npos ? "" : text.substr(unit);
  const double most = usable_range(dimension::none).largest;
  if (!(std::abs(q.value) <= most))
    throw InputError(fmt::format("is {:g}; expected a number up to {:g}", q.value, most));
  return q;
}

// The value of a key that may or may not have a dimension.
Quantity quantity(const TomlTable& table, const std::string& key) {
  std::string text;
  try {
    text = table.string(key);
  } catch (const InputError&) {
    return {table.number(key), ""};  // says so itself when it is neither
  }
  return table.at(key, [&] { return split_quantity(text); });
}

Parameter read_parameter(const TomlTable& t) {
  t.allow({"name", "keys", "min", "max", "scale", "prior_mean", "prior_sd"});
  Parameter p;
  p.name = path_name(t);
  p.keys = t.strings("keys");
  if (p.keys.empty())
    t.fail("keys",
           "names no key of the case; expected a list such as "
           "[\"interactions.ice-ice.static_friction\"]");
  const Quantity min = quantity(t, "min"), max = quantity(t, "max");
  p.min = min.value;
  p.max = max.value;
  p.unit = min.unit;
  if (max.unit != min.unit)
    t.fail("max", fmt::format("has the unit \"{}\" and min has \"{}\"; expected the same unit",
                              max.unit, min.unit));
  if (!(p.min < p.max))
    t.fail("max", fmt::format("{} is not above min = {}; expected a range that is not empty", p.max,
                              p.min));
  p.logarithmic = t.choice("scale", {"linear", "log"}, "linear") == "log";
  if (p.logarithmic && !(p.min > 0))
    t.fail("min",
           fmt::format("{} has no logarithm; expected a number above 0, or scale = \"linear\"",
                       p.min));
  if (t.has("prior_mean") != t.has("prior_sd"))
    t.fail(t.has("prior_mean") ? "prior_sd" : "prior_mean",
           "is missing; expected both prior_mean and prior_sd, or neither");
  if (t.has("prior_mean")) {
    const Quantity mean = quantity(t, "prior_mean"), sd = quantity(t, "prior_sd");
    if (mean.unit != p.unit || sd.unit != p.unit)
      t.fail("prior_mean", fmt::format("has another unit than the range; expected \"{}\"", p.unit));
    if (!(mean.value >= p.min && mean.value <= p.max))
      t.fail("prior_mean",
             fmt::format("{} lies outside the range; expected {} to {}", mean.value, p.min, p.max));
    if (!(sd.value > 0)) t.fail("prior_sd", "is not above 0; expected a standard deviation");
    p.prior_mean = mean.value;
    p.prior_sd = sd.value;
  }
  return p;
}

void read_parameters(const TomlTable& root, Study& study) {
  std::set<std::string> names, keys;
  for (const TomlTable& t : root.tables("parameters")) {
    const Parameter p = read_parameter(t);
    if (!names.insert(p.name).second)
      t.fail("name", fmt::format("\"{}\" is used twice; expected a name of its own", p.name));
    for (const std::string& key : p.keys)
      if (!keys.insert(key).second)
        t.fail("keys",
               fmt::format("\"{}\" is bound twice; expected each key of the case once", key));
    if (keys.contains("case.seed"))
      t.fail("keys", "\"case.seed\" is the study's own; expected another key");
    study.parameters.push_back(p);
  }
  if (study.parameters.empty())
    root.fail("parameters", "is missing; expected at least one [[parameters]] table");
}

std::vector<Override> read_set(const TomlTable& t) {
  std::vector<Override> set;
  const TomlTable values = t.required_table("set");
  for (const std::string& key : values.keys()) set.emplace_back(key, values.value_text(key));
  return set;
}

std::string case_path(const TomlTable& t, const std::string& study_file) {
  const auto file = std::filesystem::path(study_file).parent_path() / t.string("case");
  std::error_code unreadable;  // as a name that is too long
  if (!std::filesystem::exists(file, unreadable))
    t.fail("case", fmt::format("{} does not exist; expected a case file, relative to the study",
                               file.string()));
  return file.lexically_normal().string();
}

// Which of the parameters an experiment's case is given: those named, or all.
std::vector<bool> read_takes(const TomlTable& t, const Study& study) {
  std::vector<bool> takes(study.parameters.size(), !t.has("parameters"));
  for (const std::string& name : t.strings("parameters")) {
    const auto found = std::find_if(study.parameters.begin(), study.parameters.end(),
                                    [&](const Parameter& p) { return p.name == name; });
    if (found == study.parameters.end())
      t.fail("parameters", fmt::format("\"{}\" is no parameter of this study; expected the names "
                                       "of some",
                                       name));
    takes[static_cast<std::size_t>(found - study.parameters.begin())] = true;
  }
  return takes;
}

// Who simulates: the solver with case files, or a function of the caller.
enum class Simulates { cases, function };

void read_experiments(const TomlTable& root, const TomlTable& head, Simulates simulates,
                      Study& study) {
  if (simulates == Simulates::function) {
    study.experiments.push_back(
        {"", "the simulator", {}, std::vector<bool>(study.parameters.size(), true)});
    return;
  }
  const std::vector<TomlTable> tables = root.tables("experiments");
  if (tables.empty()) {
    study.experiments.push_back(
        {"", case_path(head, study.source), {}, std::vector<bool>(study.parameters.size(), true)});
    return;
  }
  if (head.has("case"))
    head.fail("case", "stands beside [[experiments]]; expected one or the other");
  std::set<std::string> names;
  for (const TomlTable& t : tables) {
    t.allow({"name", "case", "set", "parameters"});
    Experiment e;
    e.name = path_name(t);
    if (!names.insert(e.name).second) t.fail("name", "is used twice; expected a name of its own");
    e.case_file = case_path(t, study.source);
    if (t.has("set")) e.set = read_set(t);
    e.takes = read_takes(t, study);
    study.experiments.push_back(e);
  }
  for (std::size_t i = 0; i < study.parameters.size(); ++i)
    if (std::none_of(study.experiments.begin(), study.experiments.end(),
                     [&](const Experiment& e) { return e.takes[i]; }))
      root.fail("experiments", fmt::format("no experiment takes the parameter \"{}\"; expected at "
                                           "least one",
                                           study.parameters[i].name));
}

// The experiment that a target, an observation or a check names.
std::size_t named_experiment(const TomlTable& t, const Study& study) {
  if (study.experiments.size() == 1 && !t.has("experiment")) return 0;
  const std::string wanted = t.string("experiment");
  for (std::size_t e = 0; e < study.experiments.size(); ++e)
    if (study.experiments[e].name == wanted) return e;
  t.fail("experiment",
         fmt::format("\"{}\" is no experiment of this study; expected the name of one "
                     "of [[experiments]]",
                     wanted));
}

ResponseId response_id(const TomlTable& t, const Study& study, const std::string& name) {
  const std::size_t e = named_experiment(t, study);
  return {e, name, study.experiments.size() == 1 ? name : study.experiments[e].name + "." + name};
}

double read_effort(const TomlTable& t) {
  return t.optional_quantity("effort", dimension::time, Sign::positive).value_or(0);
}

std::string source_of(const Measurement& m) {
  const double plain = m.standard_uncertainty(), believed = m.believed_uncertainty();
  if (believed == plain) return m.sentence();
  return fmt::format("{}; taken as +- {:.2g} {}, since {} repeats hardly tell their scatter",
                     m.sentence(), believed, m.unit, m.repeats);
}

// From a measurement file, relative to the study.
Target measured_target(const TomlTable& t, const Study& study) {
  t.allow({"measurement", "response", "experiment", "effort"});
  const auto file = std::filesystem::path(study.source).parent_path() / t.string("measurement");
  const Measurement m = read_measurement(file.lexically_normal().string());
  if (m.status == MeasurementStatus::qualitative)
    t.fail("measurement", "is qualitative; expected one with a value to fit to");
  if (!(m.believed_uncertainty() > 0))
    t.fail(
        "measurement",
        fmt::format("{}: its values are identical, so that its uncertainty is zero; expected a "
                    "[reading] with the uncertainty of the instrument (its resolution / sqrt(12))",
                    m.file));
  // Another response may stand for the same measurement: another estimator of the same thing.
  return {response_id(t, study, t.string("response", m.response)),
          m.value,
          m.believed_uncertainty(),
          m.unit,
          source_of(m),
          read_effort(t),
          m.file};
}

// Given in place.
Target stated_target(const TomlTable& t, const Study& study) {
  t.allow({"response", "value", "uncertainty", "experiment", "effort"});
  const Quantity value = quantity(t, "value"), uncertainty = quantity(t, "uncertainty");
  if (uncertainty.unit != value.unit)
    t.fail("uncertainty", fmt::format("has the unit \"{}\"; expected \"{}\" as the value has",
                                      uncertainty.unit, value.unit));
  if (!(uncertainty.value > 0))
    t.fail("uncertainty",
           fmt::format("{} is not above 0; expected one standard deviation of the measured value",
                       uncertainty.value));
  return {response_id(t, study, t.string("response")), value.value,           uncertainty.value,
          value.unit.empty() ? "1" : value.unit,       "stated in the study", read_effort(t)};
}

// What a list of bench tests says of measuring this response.
void take_from_list(const TomlTable& t, const std::vector<BenchTest>& list, Observed& o) {
  const std::string name = t.string("bench_test");
  for (const BenchTest& test : list)
    for (const BenchResponse& response : test.responses)
      if (test.name == name && response.name == o.response.name) {
        o.uncertainty = response.standard_uncertainty(test.repeats);
        o.unit = response.unit;
        o.effort = test.effort(test.repeats);
        return;
      }
  t.fail("bench_test",
         fmt::format("\"{}\" with the response \"{}\" is not in the list of bench tests; expected "
                     "one that is, and study.bench_tests to name the list",
                     name, o.response.name));
}

// A response that is no target, perhaps with what measuring it would give and cost.
Observed read_observed(const TomlTable& t, const Study& study, const std::vector<BenchTest>& list) {
  t.allow({"response", "experiment", "uncertainty", "effort", "bench_test"});
  Observed o;
  o.response = response_id(t, study, t.string("response"));
  if (t.has("bench_test")) {
    if (t.has("uncertainty") || t.has("effort"))
      t.fail("bench_test", "stands beside uncertainty or effort; expected one or the other");
    take_from_list(t, list, o);
    return o;
  }
  if (t.has("uncertainty")) {
    const Quantity q = quantity(t, "uncertainty");
    if (!(q.value > 0))
      t.fail("uncertainty",
             fmt::format("{} is not above 0; expected one standard deviation of a measured value",
                         q.value));
    o.uncertainty = q.value;
    o.unit = q.unit.empty() ? "1" : q.unit;
  }
  o.effort = read_effort(t);
  return o;
}

void read_responses(const TomlTable& root, const TomlTable& head, Study& study) {
  std::vector<BenchTest> list;
  if (head.has("bench_tests"))
    list = read_bench_tests(
        (std::filesystem::path(study.source).parent_path() / head.string("bench_tests"))
            .lexically_normal()
            .string());
  std::set<std::string> seen;
  for (const TomlTable& t : root.tables("targets")) {
    study.targets.push_back(t.has("measurement") ? measured_target(t, study)
                                                 : stated_target(t, study));
    const std::string& label = study.targets.back().response.label;
    if (!seen.insert(label).second)
      t.fail("response",
             fmt::format("\"{}\" is a target twice; expected each response once", label));
  }
  if (study.targets.empty())
    root.fail("targets", "is missing; expected at least one [[targets]] table");
  for (const TomlTable& t : root.tables("observe")) {
    study.observed.push_back(read_observed(t, study, list));
    const std::string& label = study.observed.back().response.label;
    if (!seen.insert(label).second)
      t.fail("response", fmt::format("\"{}\" is named twice; expected each response once", label));
  }
}

void read_numerics(const TomlTable& root, Study& study) {
  for (const TomlTable& t : root.tables("numerics")) {
    t.allow({"name", "set", "experiment"});
    NumericsCheck check{t.string("name"), read_set(t), {}};
    if (t.has("experiment")) check.only = named_experiment(t, study);
    study.numerics.push_back(std::move(check));
  }
}

void read_direct(const TomlTable& root, Study& study) {
  const TomlTable t = root.required_table("direct");
  t.allow({"search", "evaluations"});
  const std::string word = t.choice("search", {"bobyqa", "cobyla", "nelder-mead", "crs"});
  for (const DirectSearch s :
       {DirectSearch::bobyqa, DirectSearch::cobyla, DirectSearch::nelder_mead, DirectSearch::crs})
    if (word == to_string(s)) study.direct = s;
  study.direct_evaluations = t.integer("evaluations", 1);
}

void read_compare(const TomlTable& root, Study& study) {
  for (const TomlTable& t : root.tables("compare")) {
    t.allow({"name", "values"});
    CompareSet set;
    set.name = t.string("name");
    const TomlTable values = t.required_table("values");
    for (const std::string& key : values.keys())
      if (std::none_of(study.parameters.begin(), study.parameters.end(),
                       [&](const Parameter& p) { return p.name == key; }))
        values.fail(key, "is no parameter of this study; expected the name of one");
    for (const Parameter& p : study.parameters) {
      const Quantity q = quantity(values, p.name);
      if (q.unit != p.unit)
        values.fail(p.name, fmt::format("has the unit \"{}\"; expected \"{}\"", q.unit, p.unit));
      set.values.push_back(q.value);
    }
    study.compare.push_back(set);
  }
}

Study read_text(const std::string& text, const std::string& source, Simulates simulates) {
  Study study;
  study.source = source;
  study.text = text;
  TomlDocument document(study.text, source);
  const TomlTable root = TomlTable::root(document);
  root.allow({"study", "experiments", "budget", "parameters", "targets", "observe", "compare",
              "numerics", "direct", "execution"});
  const TomlTable head = root.required_table("study");
  head.allow({"name", "case", "bench_tests", "seed", "threads"});
  study.name = path_name(head);
  study.seed = static_cast<std::uint64_t>(head.integer("seed", 0, 1));
  study.threads = head.integer("threads", 1, 1);
  read_parameters(root, study);
  read_experiments(root, head, simulates, study);
  read_responses(root, head, study);
  read_compare(root, study);
  read_numerics(root, study);
  if (root.has("direct")) read_direct(root, study);
  study.execution = read_execution(root);
  study.budget = read_budget(root, study);
  if (study.largest_total() > input_limits::batch_runs)
    root.fail("budget",
              fmt::format("makes more than {} runs; expected fewer", input_limits::batch_runs));
  return study;
}

}  // namespace

const char* to_string(DirectSearch search) {
  switch (search) {
    case DirectSearch::none:
      return "none";
    case DirectSearch::bobyqa:
      return "bobyqa";
    case DirectSearch::cobyla:
      return "cobyla";
    case DirectSearch::nelder_mead:
      return "nelder-mead";
    case DirectSearch::crs:
      return "crs";
  }
  return "";
}

Study read_study(const std::string& file) {
  return read_text(read_input_file(file, "a study file (TOML)", input_limits::toml_bytes), file,
                   Simulates::cases);
}

Study read_function_study(const std::string& text, const std::string& source) {
  return read_text(text, source, Simulates::function);
}

}  // namespace firn
