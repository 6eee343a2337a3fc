#include "calibrate/study/read_priors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "calibrate/study/read_parameters.h"
#include "experiments/material_records/material_database.h"
#include "experiments/text/csv/csv_reader.h"
#include "experiments/text/number_text.h"
#include "experiments/text/toml_document.h"
#include "experiments/text/toml_names.h"
#include "experiments/text/units.h"

namespace firn {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

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

// A record by its reference, NAME or NAME@VERSION.
MaterialRecord named_record(const TomlTable& t, const std::string& reference) {
  const std::size_t at = reference.find('@');
  int version = 0;
  if (at != reference.npos) {
    const std::string digits = reference.substr(at + 1);
    if (digits.empty() || digits.size() > 6 ||
        digits.find_first_not_of("0123456789") != digits.npos)
      t.fail("material", "names no version; expected NAME or NAME@VERSION");
    version = std::stoi(digits);
  }
  return t.at("material", [&] {
    return MaterialDatabase(material_database_file()).find(reference.substr(0, at), version).record;
  });
}

// What a record says of one parameter: its moment in the unit cube, and of the record's coordinate
// the standard deviation (0: none) and the axis of the ensemble, where it is one.
struct RecordMoment {
  UnitMoment moment;
  double sd = 0;
  std::optional<std::size_t> axis;
};

RecordMoment record_moment(const TomlTable& t, const MaterialRecord& record,
                           const MaterialParameter& m, const Parameter& p) {
  if (plain_unit(m.unit) != (p.unit.empty() ? "1" : p.unit))
    t.fail("material",
           fmt::format("{} is in \"{}\" there and in \"{}\" here; expected the same unit", m.name,
                       m.unit, p.unit.empty() ? "1" : p.unit));
  RecordMoment row;
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
  if (!(row.sd > 0)) return row;
  if ((p.logarithmic && !logarithmic && !(mean > 0)))
    t.fail("material", fmt::format("{} is {} there, which has no logarithm", m.name, mean));
  row.moment = to_unit_moment(p, mean, logarithmic);
  return row;
}

// Mean and covariance in the unit cube.
void set_record_moments(const MaterialRecord& record, const std::vector<RecordMoment>& rows,
                        Prior& prior) {
  const auto d = static_cast<Index>(rows.size());
  prior.mean.resize(d);
  prior.covariance = MatrixXd::Zero(d, d);
  for (Index i = 0; i < d; ++i)
    for (Index j = 0; j < d; ++j) {
      const RecordMoment &a = rows[static_cast<std::size_t>(i)],
                         &b = rows[static_cast<std::size_t>(j)];
      prior.mean[i] = a.moment.mean;
      const double coordinates = i == j             ? a.sd * a.sd
                                 : a.axis && b.axis ? record.ensemble->covariance[*a.axis][*b.axis]
                                                    : 0;
      prior.covariance(i, j) = coordinates * a.moment.slope * b.moment.slope;
    }
  prior.covariance.diagonal().array() += 1e-12;
}

// What a material record says of the keys that this study varies.
Prior read_material_prior(const TomlTable& t, const Study& study) {
  t.allow({"material"});
  const std::string reference = t.string("material");
  const MaterialRecord record = named_record(t, reference);
  Prior prior;
  prior.kind = Prior::Kind::joint;
  prior.text = fmt::format("the material record {}@{}", record.name, record.version);
  std::vector<RecordMoment> rows;
  for (const MaterialParameter& m : record.parameters) {
    const auto i = taken_by(study, m);
    if (!i) continue;
    const RecordMoment row = record_moment(t, record, m, study.parameters[*i]);
    if (!(row.sd > 0)) continue;
    prior.parameters.push_back(*i);
    rows.push_back(row);
  }
  if (rows.empty())
    t.fail("material", fmt::format("{} has no key of this study's parameters with an uncertainty; "
                                   "expected one that has",
                                   reference));
  set_record_moments(record, rows, prior);
  return prior;
}

}  // namespace

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

}  // namespace firn
