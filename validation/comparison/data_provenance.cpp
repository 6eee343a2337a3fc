#include "validation/comparison/data_provenance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>

#include "experiments/responses/response_expression.h"
#include "experiments/text/response_aliases.h"
#include "experiments/text/toml_document.h"

namespace firn {
namespace {

constexpr double near_value = 0.05;   // of a record's value: the same, rounded
constexpr double same_share = 0.005;  // of a measured value: the same, rounded
constexpr double same_in_uncertainty = 0.05;
constexpr double exact = 1e-9;

// Letters and digits alone, in lower case: "Section 3.3, drained" is "section33drained".
std::string plain(const std::string& text) {
  std::string letters;
  for (const char c : text)
    if (const auto u = static_cast<unsigned char>(c); std::isalnum(u) != 0 || u >= 0x80)
      letters += static_cast<char>(std::tolower(u));
  return letters;
}

std::string without_experiment(const std::string& response) {
  const auto dot = response.rfind('.');
  return dot == std::string::npos ? response : response.substr(dot + 1);
}

// The value and uncertainty of `a` in the unit of `b`; nothing for another kind of quantity.
struct Amounts {
  double value = 0, uncertainty = 0;
};
std::optional<Amounts> in_unit_of(const DataIdentity& a, const DataIdentity& b) {
  if (a.unit == b.unit) return Amounts{a.value, a.uncertainty};
  try {
    const std::optional<double> factor = conversion_factor(a.unit, b.unit);
    if (!factor) return std::nullopt;
    return Amounts{a.value * *factor, a.uncertainty * *factor};
  } catch (const InputError&) {
    return std::nullopt;  // a spelling of a record's own
  }
}

bool close(double a, double b, double share) {
  return std::abs(a - b) <= share * std::max(std::abs(a), std::abs(b));
}

bool near_to(const std::vector<double>& values, const std::vector<double>& record) {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!close(values[i], record[i], near_value)) return false;  // NaN: not close
  return true;
}

// The parameters' values with those of the ensemble's axes in their places.
std::vector<double> with_axes(const MaterialRecord& record, const std::vector<double>& axes) {
  std::vector<double> values;
  for (const MaterialParameter& p : record.parameters) values.push_back(p.value);
  for (std::size_t i = 0; i < axes.size(); ++i)
    values[record.index(record.ensemble->axes[i].parameter)] = axes[i];
  return values;
}

}  // namespace

DataIdentity identity_of(const Measurement& m, const std::vector<std::string>& operands) {
  DataIdentity d;
  d.experiment = m.experiment;
  std::vector<std::string> texts = operands;
  if (!m.response.empty()) texts.push_back(m.response);
  for (const Criterion& criterion : m.criteria)
    texts.insert(texts.end(), {criterion.lhs, criterion.rhs});
  if (m.data) texts.push_back(m.data->response);
  for (const std::string& text : texts)
    if (const ResponseExpression o = parse_response_expression(text);
        o.part != ResponseExpression::Part::number)
      d.responses.push_back(without_experiment(o.response));
  d.has_value = m.status != MeasurementStatus::qualitative;
  d.value = m.value;
  d.uncertainty = m.standard_uncertainty();
  d.unit = m.unit;
  return d;
}

DataIdentity identity_of(const UsedMeasurement& used) {
  return {used.experiment,
          {current_response_name(without_experiment(used.response))},
          true,
          used.value,
          used.uncertainty,
          used.unit};
}

std::optional<std::string> same_data(const DataIdentity& a, const DataIdentity& b) {
  const bool response = std::ranges::any_of(a.responses, [&](const std::string& name) {
    return std::ranges::count(b.responses, name) > 0;
  });
  const bool stated = !plain(a.experiment).empty() && !plain(b.experiment).empty();
  const bool one_experiment = stated && plain(a.experiment) == plain(b.experiment);
  if (response && one_experiment)
    return fmt::format("both are of the experiment \"{}\"", a.experiment);
  const auto mine = a.has_value && b.has_value ? in_unit_of(a, b) : std::nullopt;
  if (mine) {
    const double apart = std::abs(mine->value - b.value);
    const double uncertainty = std::hypot(mine->uncertainty, b.uncertainty);
    if (close(mine->value, b.value, exact) && close(mine->uncertainty, b.uncertainty, exact))
      return "value and uncertainty are the same";
    if (!response) return std::nullopt;
    if (close(mine->value, b.value, same_share) || apart <= same_in_uncertainty * uncertainty)
      return "the values are the same but for rounding";
    if (!stated && apart <= 2 * uncertainty)
      return "both measure the same response, and not both state their `experiment`";
    return std::nullopt;
  }
  if (response && !stated && a.has_value == b.has_value)
    return "both measure the same response, and not both state their `experiment`";
  return std::nullopt;
}

bool has_values_of(const MaterialRecord& record, const std::vector<double>& values) {
  if (values.empty()) return false;
  if (near_to(values, with_axes(record, {}))) return true;
  if (!record.ensemble) return false;
  for (const ReferenceSet& reference : record.ensemble->reference_sets)
    if (near_to(values, with_axes(record, reference.values))) return true;
  for (const EnsembleSample& sample : record.ensemble->samples)
    if (near_to(values, with_axes(record, sample.values))) return true;
  return false;
}

std::vector<double> values_in_case(const MaterialRecord& record, const std::string& resolved) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  TomlDocument document(resolved, "case", TomlFormat::case_file, OldNames::accept);
  const auto at = [&](const std::string& path) {
    const MaterialKey key = parse_material_key(path);
    const auto& m = key.materials;
    const std::vector<std::string> names =
        m.size() == 1 ? m : std::vector{m[0] + "-" + m[1], m[1] + "-" + m[0]};
    for (const std::string& name : names) {
      const auto node = document.root()[key.table][name][key.key];
      if (const auto number = node.value<double>()) return *number;
      if (const auto text = node.value<std::string>()) return parse_quantity(*text, key.dimension);
    }
    return none;
  };
  std::vector<double> values;
  for (const MaterialParameter& p : record.parameters) {
    const double factor = p.unit == "1" || p.unit.empty() ? 1 : parse_unit(p.unit).factor;
    values.push_back(p.keys.empty() ? none : at(p.keys.front()) / factor);
  }
  return values;
}

}  // namespace firn
