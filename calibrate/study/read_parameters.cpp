#include "calibrate/study/read_parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "experiments/text/toml_document.h"
#include "experiments/text/toml_names.h"
#include "experiments/text/units.h"

namespace firn {
namespace {

StatedQuantity split_quantity(const std::string& text) {
  std::size_t used = 0;
  StatedQuantity q;
  try {
    q.value = std::stod(text, &used);
  } catch (const std::exception&) {
    throw InputError(
        fmt::format("\"{}\" is not a number; expected a number and its unit, such as "
                    "\"10 deg\"",
                    text));
  }
  const std::size_t unit = text.find_first_not_of(' ', used);
  q.unit = unit == std::string::npos ? "" : plain_unit(text.substr(unit));
  const double most = usable_range(dimension::none).largest;
  if (!(std::abs(q.value) <= most))
    throw InputError(fmt::format("is {:g}; expected a number up to {:g}", q.value, most));
  return q;
}

// The keys of the case that a parameter is bound to; empty where none are given.
std::vector<std::string> read_bound_keys(const TomlTable& t) {
  std::vector<std::string> keys;
  for (const std::string& key : t.strings("keys")) keys.push_back(current_case_key(t, "keys", key));
  if (t.has("keys") && keys.empty())
    t.fail("keys",
           "names no key of the case; expected a list such as "
           "[\"interactions.ice-ice.static_friction\"]");
  return keys;
}

Parameter read_parameter(const TomlTable& t) {
  t.allow({"name", "keys", "min", "max", "scale", "prior_mean", "prior_sd", "integer"});
  Parameter p;
  p.name = valid_name(t);
  p.keys = read_bound_keys(t);
  p.key_places = t.element_places("keys");
  const StatedQuantity min = read_stated_quantity(t, "min"), max = read_stated_quantity(t, "max");
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
  p.integer = t.boolean("integer", false);
  if (p.integer && (p.min != std::round(p.min) || p.max != std::round(p.max)))
    t.fail("min", "the ends of an integer's range are not integers; expected whole numbers");
  if (t.has("prior_mean") != t.has("prior_sd"))
    t.fail(t.has("prior_mean") ? "prior_sd" : "prior_mean",
           "is missing; expected both prior_mean and prior_sd, or neither");
  if (t.has("prior_mean")) {
    const StatedQuantity mean = read_stated_quantity(t, "prior_mean"),
                         sd = read_stated_quantity(t, "prior_sd");
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

// Each name and each key of the case belongs to one parameter.
void require_unused(const TomlTable& t, const std::string& name,
                    const std::vector<std::string>& bound, std::set<std::string>& names,
                    std::set<std::string>& keys) {
  if (!names.insert(name).second)
    t.fail("name", fmt::format("\"{}\" is used twice; expected a unique name", name));
  for (const std::string& key : bound)
    if (!keys.insert(key).second)
      t.fail("keys", fmt::format("\"{}\" is bound twice; expected each key of the case once", key));
  if (keys.contains("case.seed"))
    t.fail("keys", "\"case.seed\" is the study's own; expected another key");
}

// A text or a number as it stands in a list of choices, for people.
std::string choice_label(const TomlTable& t, const std::string& value) {
  constexpr std::size_t longest = 60;  // bytes
  const std::string label = placeholder_text(value);
  const auto control = [](char c) { return static_cast<unsigned char>(c) < ' ' || c == 127; };
  if (label.empty() || label.size() > longest || value[0] == '[' || value[0] == '{' ||
      std::any_of(label.begin(), label.end(), control))
    t.fail(
        "choices",
        fmt::format("has an entry that cannot be shown on one line; expected numbers or texts of "
                    "at most {} bytes",
                    longest));
  return label;
}

ChoiceParameter read_choice(const TomlTable& t) {
  constexpr std::size_t most = 6;
  t.allow({"name", "keys", "choices", "prior"});
  ChoiceParameter c;
  c.name = valid_name(t);
  c.keys = read_bound_keys(t);
  c.key_places = t.element_places("keys");
  c.values = t.value_texts("choices");
  c.value_places = t.element_places("choices");
  if (c.values.size() < 2 || c.values.size() > most)
    t.fail("choices", fmt::format("has {} entries; expected 2 to {}, each of which gets separate "
                                  "runs",
                                  c.values.size(), most));
  for (const std::string& value : c.values) {
    const std::string label = choice_label(t, value);
    if (std::find(c.labels.begin(), c.labels.end(), label) != c.labels.end())
      t.fail("choices", fmt::format("has \"{}\" twice; expected different values", label));
    c.labels.push_back(label);
  }
  c.prior.assign(c.values.size(), 1 / static_cast<double>(c.values.size()));
  if (!t.has("prior")) return c;
  c.prior.clear();
  for (const std::string& text : t.value_texts("prior"))
    c.prior.push_back(t.at("prior", [&] { return split_quantity(text).value; }));
  constexpr double rounding = 1e-6;
  double sum = 0;
  for (const double p : c.prior) sum += p;
  if (c.prior.size() != c.values.size() || !(std::abs(sum - 1) < rounding) ||
      !(*std::min_element(c.prior.begin(), c.prior.end()) > 0))
    t.fail("prior", fmt::format("is no list of {} probabilities above 0 that add up to 1; expected "
                                "one for each choice",
                                c.values.size()));
  return c;
}

}  // namespace

StatedQuantity read_stated_quantity(const TomlTable& table, const std::string& key) {
  std::string text;
  try {
    text = table.string(key);
  } catch (const InputError&) {
    return {table.number(key), ""};  // says so itself when it is neither
  }
  return table.at(key, [&] { return split_quantity(text); });
}

void read_parameters(const TomlTable& root, Study& study) {
  std::set<std::string> names, keys;
  for (const TomlTable& t : root.tables("parameters")) {
    if (!t.has("choices")) {
      study.parameters.push_back(read_parameter(t));
      require_unused(t, study.parameters.back().name, study.parameters.back().keys, names, keys);
      continue;
    }
    if (study.choice)
      t.fail("choices", fmt::format("is given for \"{}\" already; expected at most one "
                                    "parameter with choices",
                                    study.choice->name));
    study.choice = read_choice(t);
    require_unused(t, study.choice->name, study.choice->keys, names, keys);
  }
  if (study.parameters.empty())
    root.fail("parameters",
              study.choice ? "have choices alone; expected at least one with a range, or a sweep"
                           : "is missing; expected at least one [[parameters]] table");
  // Points of a design that are the same would count as several.
  if (std::all_of(study.parameters.begin(), study.parameters.end(),
                  [](const Parameter& p) { return p.integer; }))
    root.fail("parameters", "are integers, all of them; expected one that is not, or a sweep");
}

void read_constraints(const TomlTable& root, Study& study) {
  constexpr double least_share = 0.01;
  std::vector<Constraint> all;
  const std::vector<TomlTable> tables = root.tables("constraints");
  for (const TomlTable& t : tables) {
    t.allow({"rule"});
    all.push_back(
        t.at("rule", [&] { return parse_constraint(t.string("rule"), study.parameters); }));
  }
  study.constraints = make_constraints(std::move(all), study.parameters);
  if (study.constraints.share < least_share)
    tables.back().fail(
        "rule", fmt::format("the constraints leave {:.2g} % of the ranges; expected at least {} %",
                            100 * study.constraints.share, 100 * least_share));
}

void read_compare(const TomlTable& root, Study& study) {
  for (const TomlTable& t : root.tables("compare")) {
    t.allow({"name", "values"});
    if (study.choice)
      t.fail("values", "is given in a study of a parameter with choices; expected no [[compare]]");
    CompareSet set;
    set.name = t.string("name");
    const TomlTable values = t.required_table("values");
    for (const std::string& key : values.keys())
      if (std::none_of(study.parameters.begin(), study.parameters.end(),
                       [&](const Parameter& p) { return p.name == key; }))
        values.fail(key, "is not a parameter of this study; expected the name of one");
    for (const Parameter& p : study.parameters) {
      const StatedQuantity q = read_stated_quantity(values, p.name);
      if (q.unit != p.unit)
        values.fail(p.name, fmt::format("has the unit \"{}\"; expected \"{}\"", q.unit, p.unit));
      set.values.push_back(q.value);
    }
    study.compare.push_back(set);
  }
}

}  // namespace firn
