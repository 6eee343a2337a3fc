#include "calibrate/study_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "experiments/measurement.h"
#include "experiments/toml_reader.h"

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
  if (!std::isfinite(q.value)) throw InputError("is not finite; expected a finite number");
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
  p.name = t.string("name");
  if (p.name.empty()) t.fail("name", "is empty; expected a name");
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

// From a measurement file, relative to the study.
Target measured_target(const TomlTable& t, const std::string& study_file) {
  t.allow({"measurement", "response"});
  const auto file = std::filesystem::path(study_file).parent_path() / t.string("measurement");
  const Measurement m = read_measurement(file.lexically_normal().string());
  if (m.status == MeasurementStatus::qualitative)
    t.fail("measurement", "is qualitative; expected one with a value to fit to");
  // Another response may stand for the same measurement: another estimator of the same thing.
  return {t.string("response", m.response), m.value, m.standard_uncertainty(), m.unit,
          m.sentence()};
}

// Given in place.
Target stated_target(const TomlTable& t) {
  t.allow({"response", "value", "uncertainty"});
  const Quantity value = quantity(t, "value"), uncertainty = quantity(t, "uncertainty");
  if (uncertainty.unit != value.unit)
    t.fail("uncertainty", fmt::format("has the unit \"{}\"; expected \"{}\" as the value has",
                                      uncertainty.unit, value.unit));
  if (!(uncertainty.value > 0))
    t.fail("uncertainty",
           fmt::format("{} is not above 0; expected one standard deviation of the measured value",
                       uncertainty.value));
  return {t.string("response"), value.value, uncertainty.value,
          value.unit.empty() ? "1" : value.unit, "stated in the study"};
}

void read_responses(const TomlTable& root, Study& study) {
  std::set<std::string> seen;
  for (const TomlTable& t : root.tables("targets")) {
    study.targets.push_back(t.has("measurement") ? measured_target(t, study.source)
                                                 : stated_target(t));
    if (!seen.insert(study.targets.back().response).second)
      t.fail("response", fmt::format("\"{}\" is a target twice; expected each response once",
                                     study.targets.back().response));
  }
  if (study.targets.empty())
    root.fail("targets", "is missing; expected at least one [[targets]] table");
  for (const TomlTable& t : root.tables("observe")) {
    t.allow({"response"});
    study.observed.push_back(t.string("response"));
    if (!seen.insert(study.observed.back()).second)
      t.fail("response", fmt::format("\"{}\" is named twice; expected each response once",
                                     study.observed.back()));
  }
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

Budget read_budget(const TomlTable& root, std::size_t parameters) {
  const TomlTable t = root.required_table("budget");
  t.allow({"centre_runs", "design_points", "runs_per_point", "refine_rounds", "refine_points",
           "confirm_runs", "anchor_runs", "compare_runs"});
  Budget b;
  b.centre_runs = t.integer("centre_runs", 1);
  b.design_points = t.integer("design_points", 1);
  b.runs_per_point = t.integer("runs_per_point", 1);
  b.refine_rounds = t.integer("refine_rounds", 0, 1);
  b.refine_points = t.integer("refine_points", 0, 2);
  b.confirm_runs = t.integer("confirm_runs", 2, 3);
  b.anchor_runs = t.integer("anchor_runs", 0, 0);
  b.compare_runs = t.integer("compare_runs", 0, 1);
  // A linear trend has one coefficient more than there are parameters; one more point judges it.
  const int needed = static_cast<int>(parameters) + 1;
  if (b.design_points < needed)
    t.fail("design_points",
           fmt::format("{} cannot carry a fit of {} parameters; expected at least {}",
                       b.design_points, parameters, needed));
  if (b.centre_runs < 2 && b.runs_per_point < 2)
    t.fail("centre_runs",
           "leaves no point with two seeds, so that the noise stays unknown; expected at least 2 "
           "here or in runs_per_point");
  return b;
}

}  // namespace

int Budget::largest_total(std::size_t compare_sets) const {
  return centre_runs + design_points * runs_per_point +
         refine_rounds * refine_points * runs_per_point + confirm_runs + 2 * anchor_runs +
         static_cast<int>(compare_sets) * compare_runs;
}

Study read_study(const std::string& file) {
  namespace fs = std::filesystem;
  std::ifstream in(file);
  if (!in) throw InputError(fmt::format("{}: cannot be read; expected a study file (TOML)", file));
  std::ostringstream text;
  text << in.rdbuf();

  Study study;
  study.source = file;
  study.text = text.str();
  TomlDocument document(study.text, file);
  const TomlTable root = TomlTable::root(document);
  root.allow({"study", "budget", "parameters", "targets", "observe", "compare"});
  const TomlTable head = root.required_table("study");
  head.allow({"name", "case", "seed", "threads"});
  study.name = head.string("name");
  if (study.name.empty() || study.name.find('/') != std::string::npos || study.name[0] == '.')
    head.fail("name", "is empty or no name of a folder; expected a plain name");
  study.case_file = (fs::path(file).parent_path() / head.string("case")).string();
  if (!fs::exists(study.case_file))
    head.fail("case", fmt::format("{} does not exist; expected a case file, relative to the study",
                                  study.case_file));
  study.seed = static_cast<std::uint64_t>(head.integer("seed", 0, 1));
  study.threads = head.integer("threads", 1, 1);
  read_parameters(root, study);
  read_responses(root, study);
  read_compare(root, study);
  study.budget = read_budget(root, study.parameters.size());
  return study;
}

}  // namespace firn
