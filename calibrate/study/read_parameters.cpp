#include "calibrate/study/read_parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "experiments/material_records/material_database.h"
#include "experiments/text/csv_reader.h"
#include "experiments/text/number_text.h"
#include "experiments/text/toml_document.h"
#include "experiments/text/toml_names.h"
#include "experiments/text/units.h"

namespace firn {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

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
  q.unit = unit == std::string::npos ? "" : text.substr(unit);
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
  c.values = t.value_texts("choices");
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

std::size_t named_parameter(const TomlTable& t, const Study& study) {
  const std::string name = t.string("parameter");
  for (std::size_t i = 0; i < study.parameters.size(); ++i)
    if (study.parameters[i].name == name) return i;
  t.fail("parameter",
         fmt::format("\"{}\" is not a parameter of this study; expected the name of one", name));
}

// A number in the unit of the parameter's range.
double in_unit_of(const TomlTable& t, const char* key, const Parameter& p) {
  const StatedQuantity q = read_stated_quantity(t, key);
  if (q.unit != p.unit)
    t.fail(key,
           fmt::format("has the unit \"{}\"; expected \"{}\", that of the range", q.unit, p.unit));
  return q.value;
}

double above(const TomlTable& t, const char* key, double value, double least) {
  if (!(value > least)) t.fail(key, fmt::format("is {}; expected a number above {}", value, least));
  return value;
}

Prior read_scalar_prior(const TomlTable& t, const Study& study) {
  Prior prior;
  prior.parameters = {named_parameter(t, study)};
  const Parameter& p = study.parameters[prior.parameters[0]];
  const std::string kind = t.choice("kind", {"normal", "log-normal", "beta", "uniform"});
  if (kind == "normal") {
    t.allow({"parameter", "kind", "mean", "sd"});
    prior.a = in_unit_of(t, "mean", p);
    prior.b = above(t, "sd", in_unit_of(t, "sd", p), 0);
    const std::string unit = unit_suffix(p.unit);
    prior.text = fmt::format("normal, {:.4g}{} ± {:.4g}{}", prior.a, unit, prior.b, unit);
  } else if (kind == "log-normal") {
    t.allow({"parameter", "kind", "median", "factor"});
    prior.kind = Prior::Kind::log_normal;
    if (!(p.min > 0))
      t.fail(
          "kind",
          fmt::format("is log-normal, and the range of {} begins at {}; expected a range above 0",
                      p.name, p.min));
    const double median = above(t, "median", in_unit_of(t, "median", p), 0);
    const double factor = above(t, "factor", t.number("factor"), 1);
    prior.a = std::log(median);
    prior.b = std::log(factor);
    prior.text = fmt::format("log-normal, {:.4g}{} times or divided by {:.3g}", median,
                             unit_suffix(p.unit), factor);
  } else {
    t.allow({"parameter", "kind", "alpha", "beta"});
    prior.kind = Prior::Kind::beta;
    prior.a = above(t, "alpha", t.number("alpha"), 1);
    prior.b = above(t, "beta", t.number("beta"), 1);
    prior.text = fmt::format("beta({:.3g}, {:.3g}) over its range", prior.a, prior.b);
  }
  return prior;
}

// A Gaussian for the parameters whose columns hold numbers: rows of samples in the unit cube.
void set_moments(const TomlTable& t, const char* key, const MatrixXd& samples,
                 const VectorXd& weight, Prior& prior) {
  prior.mean = samples.transpose() * weight / weight.sum();
  const MatrixXd off = samples.rowwise() - prior.mean.transpose();
  prior.covariance = off.transpose() * weight.asDiagonal() * off / weight.sum();
  if (!prior.covariance.allFinite()) t.fail(key, "its samples have no finite covariance");
  prior.covariance.diagonal().array() += 1e-12;
}

// The posterior of another study, from its folder.
Prior read_study_prior(const TomlTable& t, const Study& study) {
  t.allow({"study"});
  const std::string folder = (std::filesystem::path(study.source).parent_path() / t.string("study"))
                                 .lexically_normal()
                                 .string();
  const std::string file = (std::filesystem::path(folder) / "posterior.csv").string();
  const std::vector<CsvRow> rows = t.at("study", [&] { return read_csv_table(file); });
  Prior prior;
  prior.kind = Prior::Kind::joint;
  prior.text = fmt::format("the posterior of the study in {}", folder);
  std::vector<CsvColumn> columns;
  const auto& header = rows.front().fields;
  for (std::size_t i = 0; i < study.parameters.size(); ++i) {
    const Parameter& p = study.parameters[i];
    const std::string name = p.unit.empty() ? p.name : p.name + " / " + p.unit;
    const auto found = std::find(header.begin(), header.end(), name);
    if (found == header.end()) continue;
    prior.parameters.push_back(i);
    columns.push_back({name, static_cast<std::size_t>(found - header.begin()), 1});
  }
  if (columns.empty())
    t.fail("study", fmt::format("{} has no column for a parameter of this study; expected the same "
                                "names and units",
                                file));
  const auto count = static_cast<Index>(rows.size() - 1), d = static_cast<Index>(columns.size());
  if (count < 10 * d) t.fail("study", fmt::format("{} has too few samples", file));
  MatrixXd samples(count, d);
  VectorXd weight(count);
  const CsvColumn weights =
      t.at("study", [&] { return find_csv_column(file, rows[0], "weight", {}); });
  for (Index s = 0; s < count; ++s) {
    const CsvRow& row = rows[static_cast<std::size_t>(s) + 1];
    weight[s] = t.at("study", [&] { return csv_number(file, row, weights); });
    for (Index i = 0; i < d; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const Parameter& p = study.parameters[prior.parameters[k]];
      const double value = t.at("study", [&] { return csv_number(file, row, columns[k]); });
      if (p.logarithmic && !(value > 0))
        t.fail("study", fmt::format("{}:{}: {} has no logarithm", file, row.line, value));
      samples(s, i) = p.to_unit(value);
    }
  }
  if (!(weight.minCoeff() >= 0) || !(weight.sum() > 0))
    t.fail("study", fmt::format("{}: weights are not above 0", file));
  set_moments(t, "study", samples, weight, prior);
  return prior;
}

// The parameter of the study that takes one of these keys of a case.
std::optional<std::size_t> taken_by(const Study& study, const MaterialParameter& m) {
  for (std::size_t i = 0; i < study.parameters.size(); ++i)
    for (const std::string& key : m.keys)
      if (std::ranges::count(study.parameters[i].keys, current_case_path(key)) > 0) return i;
  return std::nullopt;
}

// Mean and standard deviation of a record's coordinate, a value or its logarithm, in the unit cube.
// Between the two scales, to first order.
struct UnitMoment {
  double mean = 0, slope = 0;  // slope: of the unit cube by the coordinate
};
UnitMoment to_unit_moment(const Parameter& p, double mean, bool logarithmic) {
  const double value = logarithmic ? std::exp(mean) : mean;
  const double by_value = 1 / (p.width() * (p.logarithmic ? value : 1));
  return {p.to_unit(value), by_value * (logarithmic ? value : 1)};
}

// What a material record says of the keys that this study varies.
Prior read_material_prior(const TomlTable& t, const Study& study) {
  t.allow({"material"});
  const std::string reference = t.string("material");
  const std::size_t at = reference.find('@');
  int version = 0;
  if (at != reference.npos) {
    const std::string digits = reference.substr(at + 1);
    if (digits.empty() || digits.size() > 6 ||
        digits.find_first_not_of("0123456789") != digits.npos)
      t.fail("material", "names no version; expected NAME or NAME@VERSION");
    version = std::stoi(digits);
  }
  const MaterialRecord record = t.at("material", [&] {
    return MaterialDatabase(material_database_file()).find(reference.substr(0, at), version).record;
  });
  Prior prior;
  prior.kind = Prior::Kind::joint;
  prior.text = fmt::format("the material record {}@{}", record.name, record.version);
  struct Row {
    UnitMoment moment;
    double sd = 0;                    // of the coordinate
    std::optional<std::size_t> axis;  // of the ensemble
  };
  std::vector<Row> rows;
  for (const MaterialParameter& m : record.parameters) {
    const auto i = taken_by(study, m);
    if (!i) continue;
    const Parameter& p = study.parameters[*i];
    if (m.unit != (p.unit.empty() ? "1" : p.unit))
      t.fail("material",
             fmt::format("{} is in \"{}\" there and in \"{}\" here; expected the same unit", m.name,
                         m.unit, p.unit.empty() ? "1" : p.unit));
    Row row;
    double mean = m.value;
    bool logarithmic = false;
    if (record.ensemble)
      for (std::size_t k = 0; k < record.ensemble->axes.size(); ++k)
        if (const EnsembleAxis& axis = record.ensemble->axes[k]; axis.parameter == m.name) {
          row.axis = k;
          mean = axis.mean;
          logarithmic = axis.scale == Scale::logarithmic;
          row.sd = std::sqrt(record.ensemble->covariance[k][k]);
        }
    if (!row.axis) row.sd = m.uncertainty.value_or(0);
    if (!(row.sd > 0)) continue;
    if ((p.logarithmic && !logarithmic && !(mean > 0)))
      t.fail("material", fmt::format("{} is {} there, which has no logarithm", m.name, mean));
    row.moment = to_unit_moment(p, mean, logarithmic);
    prior.parameters.push_back(*i);
    rows.push_back(row);
  }
  if (rows.empty())
    t.fail("material", fmt::format("{} has no key of this study's parameters with an uncertainty; "
                                   "expected one that has",
                                   reference));
  const auto d = static_cast<Index>(rows.size());
  prior.mean.resize(d);
  prior.covariance = MatrixXd::Zero(d, d);
  for (Index i = 0; i < d; ++i)
    for (Index j = 0; j < d; ++j) {
      const Row &a = rows[static_cast<std::size_t>(i)], &b = rows[static_cast<std::size_t>(j)];
      prior.mean[i] = a.moment.mean;
      const double coordinates = i == j             ? a.sd * a.sd
                                 : a.axis && b.axis ? record.ensemble->covariance[*a.axis][*b.axis]
                                                    : 0;
      prior.covariance(i, j) = coordinates * a.moment.slope * b.moment.slope;
    }
  prior.covariance.diagonal().array() += 1e-12;
  return prior;
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

void read_priors(const TomlTable& root, Study& study) {
  for (const TomlTable& t : root.tables("priors")) {
    if (t.has("kind") && t.string("kind") == "uniform") {  // as without a prior
      t.allow({"parameter", "kind"});
      named_parameter(t, study);
      continue;
    }
    study.priors.push_back(t.has("study")      ? read_study_prior(t, study)
                           : t.has("material") ? read_material_prior(t, study)
                                               : read_scalar_prior(t, study));
    const Prior& prior = study.priors.back();
    if (prior.kind == Prior::Kind::joint && prior.covariance.llt().info() != Eigen::Success)
      t.fail(t.has("study") ? "study" : "material",
             "has a covariance that is not positive definite");
  }
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
