// What a material record must hold before it is kept.
#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <set>

#include "experiments/material_records/material_json.h"
#include "experiments/material_records/material_names.h"
#include "experiments/material_records/material_record.h"
#include "experiments/system/text_encoding.h"
#include "firn/math.h"

namespace firn {
namespace {

[[noreturn]] void refuse(const std::string& field, const std::string& message) {
  throw InputError(fmt::format("{}: {}", field, message));
}

void require_text(const std::string& field, const std::string& text, const char* wanted) {
  if (text.empty()) refuse(field, fmt::format("missing; expected {}", wanted));
}

void require_finite(const std::string& field, double value) {
  if (!std::isfinite(value)) refuse(field, fmt::format("is {}; expected a finite number", value));
}

void require_interval(const std::string& field, const Interval& i) {
  require_finite(field, i.low);
  require_finite(field, i.high);
  if (i.low > i.high)
    refuse(field,
           fmt::format("runs from {} down to {}; expected the lower end first", i.low, i.high));
}

Dimension require_unit(const std::string& field, const std::string& unit) {
  if (unit == "1") return dimension::none;
  require_text(field, unit, "a unit, \"1\" for a bare number");
  try {
    return parse_unit(unit).dimension;
  } catch (const InputError& e) {
    refuse(field, e.what());
  }
}

// That every case which the keys set accepts the value.
void require_in_range(const std::string& field, const MaterialParameter& p, double value) {
  for (const std::string& text : p.keys) {
    const MaterialKey key = parse_material_key(text);
    if (!key.range.contains(value))
      refuse(field, fmt::format("is {}; expected {} for {}", value, key.range.expected, key.key));
  }
}

void check_parameter(const std::string& field, const MaterialParameter& p,
                     const std::vector<std::string>& materials, std::set<std::string>& bound) {
  if (!has_name_characters(p.name, "_-"))
    refuse(field + ".name", fmt::format("is \"{}\"; expected letters, digits, _ and -", p.name));
  if (p.keys.empty()) refuse(field + ".keys", "are none; expected case keys that take the value");
  const Dimension dimension = require_unit(field + ".unit", p.unit);
  for (std::size_t i = 0; i < p.keys.size(); ++i) {
    const std::string place = fmt::format("{}.keys.{}", field, i);
    const MaterialKey key = [&] {
      try {
        return parse_material_key(p.keys[i]);
      } catch (const InputError& e) {
        refuse(place, e.what());
      }
    }();
    for (const std::string& m : key.materials)
      if (std::ranges::find(materials, m) == materials.end())
        refuse(place, fmt::format("is about \"{}\", which is none of the record's materials; "
                                  "expected one of {}",
                                  m, comma_list(materials)));
    if (!(key.dimension == dimension))
      refuse(field + ".unit", fmt::format("is \"{}\", but {} takes {}; expected a unit that fits",
                                          p.unit, key.key, dimension_name(key.dimension)));
    if (!bound.insert(p.keys[i]).second)
      refuse(place, fmt::format("\"{}\" is bound twice; expected one parameter a key", p.keys[i]));
  }
  require_finite(field + ".value", p.value);
  require_in_range(field + ".value", p, p.value);
  if (p.uncertainty && !(*p.uncertainty >= 0 && std::isfinite(*p.uncertainty)))
    refuse(field + ".uncertainty", fmt::format("is {}; expected at least 0", *p.uncertainty));
  if (p.interval_95) require_interval(field + ".interval_95", *p.interval_95);
}

void check_property(const std::string& field, const MaterialProperty& p) {
  require_text(field + ".name", p.name, "what the property is");
  if (!p.value && !p.range && p.statement.empty())
    refuse(field, "has no content; expected a value, a range or a statement");
  if (p.value) require_finite(field + ".value", *p.value);
  if (p.uncertainty && !(p.value && *p.uncertainty >= 0 && std::isfinite(*p.uncertainty)))
    refuse(field + ".uncertainty", "has no value; expected at least 0, together with a value");
  if (p.range) require_interval(field + ".range", *p.range);
  if (p.value || p.range) require_text(field + ".unit", p.unit, "a unit, \"1\" for a bare number");
}

// Symmetric, and no direction with a negative variance beyond rounding.
void check_covariance(const std::string& field, const std::vector<std::vector<double>>& rows,
                      std::size_t n) {
  if (rows.size() != n) refuse(field, fmt::format("has {} rows; expected {}", rows.size(), n));
  Eigen::MatrixXd m(n, n);
  for (std::size_t i = 0; i < n; ++i) {
    if (rows[i].size() != n)
      refuse(fmt::format("{}.{}", field, i),
             fmt::format("has {} numbers; expected {}", rows[i].size(), n));
    for (std::size_t j = 0; j < n; ++j) {
      require_finite(fmt::format("{}.{}.{}", field, i, j), rows[i][j]);
      m(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = rows[i][j];
    }
  }
  if (m != m.transpose()) refuse(field, "is not symmetric; expected a covariance");
  const double largest = m.cwiseAbs().maxCoeff();
  if (symmetric_eigenvalues(m).minCoeff() < -1e-9 * largest)
    refuse(field, "has a negative variance in some direction; expected a covariance");
}

void check_responses(const std::string& field, const std::vector<MaterialResponse>& all) {
  for (std::size_t i = 0; i < all.size(); ++i) {
    require_text(fmt::format("{}.{}.name", field, i), all[i].name, "a response");
    require_finite(fmt::format("{}.{}.value", field, i), all[i].value);
  }
}

void check_ensemble(const MaterialRecord& r) {
  const PosteriorEnsemble& f = *r.ensemble;
  const std::size_t n = f.axes.size();
  if (n == 0) refuse("posterior_ensemble.axes", "are none; expected the parameters that vary");
  std::set<std::string> names;
  for (std::size_t i = 0; i < n; ++i) {
    const EnsembleAxis& axis = f.axes[i];
    const std::string field = fmt::format("posterior_ensemble.axes.{}", i);
    if (std::ranges::find(r.parameters, axis.parameter, &MaterialParameter::name) ==
        r.parameters.end())
      refuse(field + ".parameter",
             fmt::format("\"{}\" is not a parameter of the record; expected one", axis.parameter));
    if (!names.insert(axis.parameter).second)
      refuse(field + ".parameter",
             fmt::format("\"{}\" is there twice; expected each parameter once", axis.parameter));
    require_interval(field + ".bounds", axis.bounds);
    if (!(axis.bounds.low < axis.bounds.high))
      refuse(field + ".bounds", "are a point; expected a range");
    if (axis.scale == Scale::logarithmic && !(axis.bounds.low > 0))
      refuse(field + ".bounds", "reach zero; expected more for a logarithmic scale");
    require_finite(field + ".mean", axis.mean);
  }
  const auto check_values = [&](const std::string& field, const std::vector<double>& values) {
    if (values.size() != n)
      refuse(field, fmt::format("has {} numbers; expected {}", values.size(), n));
    for (std::size_t i = 0; i < n; ++i) {
      const std::string place = fmt::format("{}.{}", field, i);
      if (!(values[i] >= f.axes[i].bounds.low && values[i] <= f.axes[i].bounds.high))
        refuse(place, fmt::format("is {}; expected a value within the bounds {} to {}", values[i],
                                  f.axes[i].bounds.low, f.axes[i].bounds.high));
      require_in_range(place, r.parameters[r.index(f.axes[i].parameter)], values[i]);
    }
  };
  check_covariance("posterior_ensemble.covariance", f.covariance, n);
  for (std::size_t i = 0; i < f.combinations.size(); ++i)
    if (f.combinations[i].coefficients.size() != n)
      refuse(fmt::format("posterior_ensemble.combinations.{}.coefficients", i),
             fmt::format("are {}; expected {}", f.combinations[i].coefficients.size(), n));
  double sum = 0;
  for (std::size_t i = 0; i < f.samples.size(); ++i) {
    const std::string field = fmt::format("posterior_ensemble.samples.{}", i);
    check_values(field + ".values", f.samples[i].values);
    if (!(f.samples[i].weight > 0))
      refuse(field + ".weight", fmt::format("is {}; expected more than 0", f.samples[i].weight));
    sum += f.samples[i].weight;
  }
  if (!f.samples.empty() && std::abs(sum - 1) > 1e-6)
    refuse("posterior_ensemble.samples", fmt::format("weigh {} together; expected 1", sum));
  for (std::size_t i = 0; i < f.reference_sets.size(); ++i) {
    const ReferenceSet& a = f.reference_sets[i];
    const std::string field = fmt::format("posterior_ensemble.reference_sets.{}", i);
    require_text(field + ".name", a.name, "a name");
    if (std::ranges::all_of(a.name, [](unsigned char c) { return c < 128 && std::isdigit(c); }))
      refuse(field + ".name", "is a number, like a sample's; expected a word");
    check_values(field + ".values", a.values);
    check_responses(field + ".predicted", a.predicted);
    for (std::size_t k = 0; k < a.runs.size(); ++k)
      check_responses(fmt::format("{}.runs.{}.responses", field, k), a.runs[k].responses);
  }
}

bool is_hash(const std::string& text) {
  return text.size() == 64 && std::ranges::all_of(text, [](char c) {
           return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
         });
}

// 2026-11-21, with or without T18:02:11Z.
bool is_date(const std::string& text) {
  constexpr std::string_view shape = "0000-00-00T00:00:00Z";
  if (text.size() != 10 && text.size() != shape.size()) return false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool digit = text[i] >= '0' && text[i] <= '9';
    if (shape[i] == '0' ? !digit : text[i] != shape[i]) return false;
  }
  const int month = std::stoi(text.substr(5, 2)), day = std::stoi(text.substr(8, 2));
  return month >= 1 && month <= 12 && day >= 1 && day <= 31;
}

void check_provenance(const MaterialRecord& r) {
  const Provenance& p = r.provenance;
  require_text("provenance.author", p.author, "who answers for the record");
  if (!is_date(p.date))
    refuse("provenance.date",
           fmt::format("is \"{}\"; expected a date such as 2026-11-21 or 2026-11-21T18:02:11Z",
                       p.date));
  require_text("provenance.source", p.source,
               "where the values come from: publication and table, notebook, study");
  for (std::size_t i = 0; i < p.raw_data.size(); ++i) {
    const std::string field = fmt::format("provenance.raw_data.{}", i);
    require_text(field + ".what", p.raw_data[i].what, "what the file is");
    require_text(field + ".file", p.raw_data[i].file, "a file");
    if (!is_hash(p.raw_data[i].sha256))
      refuse(field + ".sha256", "is no hash; expected 64 lower-case hexadecimal digits");
  }
  const bool needs_data = r.kind == RecordKind::measured || r.kind == RecordKind::calibrated;
  if (needs_data && p.raw_data.empty())
    refuse("provenance.raw_data", fmt::format("is missing; expected the files, with their hashes, "
                                              "that a {} record was made from",
                                              to_string(r.kind)));
  for (std::size_t i = 0; i < p.measurements.size(); ++i) {
    const UsedMeasurement& m = p.measurements[i];
    const std::string field = fmt::format("provenance.measurements.{}", i);
    require_text(field + ".response", m.response, "the response that was measured");
    require_text(field + ".source", m.source, "where the measurement comes from");
    require_finite(field + ".value", m.value);
    if (!(m.uncertainty >= 0 && std::isfinite(m.uncertainty)))
      refuse(field + ".uncertainty", fmt::format("is {}; expected at least 0", m.uncertainty));
    if (!(m.discrepancy >= 0 && std::isfinite(m.discrepancy)))
      refuse(field + ".discrepancy", fmt::format("is {}; expected at least 0", m.discrepancy));
  }
  if (r.kind != RecordKind::calibrated) return;
  require_text("provenance.program.version", p.program_version, "of the program that simulated");
  require_text("provenance.program.commit", p.program_commit, "of the program that simulated");
  require_text("provenance.study", p.study, "the study's name");
  require_text("provenance.program.identity", p.program, "of the program that simulated");
  if (p.cases.empty()) refuse("provenance.cases", "is missing; expected the complete cases");
  for (std::size_t i = 0; i < p.cases.size(); ++i) {
    require_text(fmt::format("provenance.cases.{}.text", i), p.cases[i].text, "a complete case");
    for (const std::string& name : p.cases[i].parameters)
      if (std::ranges::find(r.parameters, name, &MaterialParameter::name) == r.parameters.end())
        refuse(fmt::format("provenance.cases.{}.parameters", i),
               fmt::format("\"{}\" is not a parameter of the record; expected one", name));
  }
  require_text("provenance.command", p.command, "what makes the values again");
  if (p.measurements.empty())
    refuse("provenance.measurements", "is missing; expected what the values were fitted to");
  if (p.seeds.empty()) refuse("provenance.seeds", "is missing; expected those of the runs");
  if (p.estimators.empty())
    refuse("provenance.estimators", "is missing; expected how each response was measured");
}

// Text that readers of records refuse must not be written either.
void check_text(const MaterialRecord& r) {
  const nlohmann::ordered_json flat = to_json(r).flatten();
  for (const auto& [place, value] : flat.items()) {
    if (!value.is_string()) continue;
    std::string field = place.substr(1);
    std::ranges::replace(field, '/', '.');
    const bool line = field.ends_with(".name") || field.ends_with("title");
    const auto& text = value.get_ref<const std::string&>();
    const std::string found = line ? encode::first_unprintable(text) : encode::first_control(text);
    if (!found.empty())
      refuse(field, fmt::format("has the character {}; expected printable text", found));
  }
}

}  // namespace

void check(const MaterialRecord& r) {
  if (!has_name_characters(r.name, "_-.") || r.name.front() == '.' || r.name.size() > 100)
    refuse("name",
           fmt::format("is \"{}\"; expected letters, digits, _, - and ., at most 100", r.name));
  require_text("title", r.title, "one line that says what the record is");
  if (r.materials.empty() || r.materials.size() > 2)
    refuse("materials", fmt::format("are {}; expected one, or a pair", r.materials.size()));
  for (std::size_t i = 0; i < r.materials.size(); ++i)
    if (!has_name_characters(r.materials[i], "_"))
      refuse(fmt::format("materials.{}", i),
             fmt::format("is \"{}\"; expected letters, digits and _", r.materials[i]));
  if (r.parameters.empty() && r.properties.empty())
    refuse("parameters", "are none, nor are there properties; expected something that is known");
  std::set<std::string> names, keys;
  for (std::size_t i = 0; i < r.parameters.size(); ++i) {
    const std::string field = fmt::format("parameters.{}", i);
    check_parameter(field, r.parameters[i], r.materials, keys);
    if (!names.insert(r.parameters[i].name).second)
      refuse(field + ".name",
             fmt::format("\"{}\" is taken already; expected another name", r.parameters[i].name));
  }
  for (std::size_t i = 0; i < r.properties.size(); ++i)
    check_property(fmt::format("properties.{}", i), r.properties[i]);
  if (r.ensemble) check_ensemble(r);
  for (std::size_t i = 0; i < r.scope.size(); ++i) {
    require_text(fmt::format("scope.{}.name", i), r.scope[i].name, "what the limit is of");
    require_text(fmt::format("scope.{}.statement", i), r.scope[i].statement, "where it holds");
  }
  check_text(r);
  if (r.scope.empty()) refuse("scope", "is missing; expected where the values hold");
  check_provenance(r);
}

}  // namespace firn
