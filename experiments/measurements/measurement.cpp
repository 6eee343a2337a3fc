#include "experiments/measurements/measurement.h"

#include <fmt/core.h>

#include <algorithm>
#include <cassert>
#include <charconv>
#include <cmath>
#include <filesystem>

#include "experiments/analysis/sample_statistics.h"
#include "experiments/measurements/measured_data.h"
#include "experiments/system/input_file.h"
#include "experiments/system/input_limits.h"
#include "experiments/text/number_text.h"
#include "experiments/text/response_aliases.h"
#include "experiments/text/toml_document.h"
#include "experiments/text/toml_names.h"
#include "experiments/text/units.h"

namespace firn {
namespace {

constexpr const char* kQuantity = "a number and its unit, such as \"10 deg\"";

UnitValue quantity(const TomlTable& t, std::string_view key) {
  const std::string& text = t.text(key, kQuantity);
  return t.at(key, [&] { return parse_unit_value(text); });
}

double same_unit(const TomlTable& t, std::string_view key, const std::string& unit) {
  const UnitValue q = quantity(t, key);
  if (q.unit != unit) {
    t.fail(key,
           fmt::format("has the unit \"{}\"; expected \"{}\", as the value has", q.unit, unit));
  }
  return q.value;
}

double above_zero(const TomlTable& t, std::string_view key, const std::string& unit) {
  const double value = same_unit(t, key, unit);
  if (!(value > 0)) t.fail(key, fmt::format("is {} {}; expected more than zero", value, unit));
  return value;
}

void set_statistics(const std::vector<double>& values, Measurement& m) {
  const double n = static_cast<double>(values.size());
  double sum = 0, squares = 0;
  for (double v : values) sum += v;
  m.value = sum / n;
  for (double v : values) squares += (v - m.value) * (v - m.value);
  m.standard_deviation = std::sqrt(squares / (n - 1));
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  m.minimum = *low;
  m.maximum = *high;
  m.repeats = static_cast<int>(values.size());
}

// The list `values = ["10 deg", "11 deg"]`.
void read_value_list(const TomlTable& t, Measurement& m) {
  for (const std::string& text :
       t.strings("values", "quantities, such as [\"9 deg\", \"11 deg\"]")) {
    const UnitValue q =
        t.at_element("values", m.values.size(), [&] { return parse_unit_value(text); });
    if (m.values.empty()) m.unit = q.unit;
    if (q.unit != m.unit) {
      t.fail_element(
          "values", m.values.size(),
          fmt::format("has the units \"{}\" and \"{}\"; expected one for all", m.unit, q.unit));
    }
    m.values.push_back(q.value);
  }
}

// The column `values = { file = "angles.csv", column = "angle", unit = "deg" }`.
void read_value_column(const TomlTable& t, const std::string& directory, Measurement& m) {
  t.allow({"file", "column", "unit"});
  m.unit = plain_unit(t.string("unit"));
  const Unit unit = m.unit == "1" ? Unit{} : t.at("unit", [&] { return parse_unit(m.unit); });
  const auto file = (std::filesystem::path(directory) / t.string("file")).lexically_normal();
  m.values = read_csv_values(file.string(), t.string("column"), unit);
}

// The repeats one by one: they give the mean, the number and the scatter.
void read_measured_values(const TomlTable& t, const std::string& directory, Measurement& m) {
  for (const char* key : {"value", "repeats", "scatter"}) {
    if (t.has(key)) t.fail(key, "follows from `values`; expected one of the two");
  }
  if (t.is_list("values"))
    read_value_list(t, m);
  else if (t.is_table("values"))
    read_value_column(t.required_table("values"), directory, m);
  else
    t.fail("values",
           fmt::format("is {}; expected a list such as [\"9 deg\", \"11 deg\"], or {{ file, "
                       "column, unit }}",
                       t.value_text("values")));
  if (m.values.size() < 2) t.fail("values", "has fewer than two entries; expected at least two");
  m.scatter = ScatterKind::values;
  set_statistics(m.values, m);
}

void read_scatter(const TomlTable& t, Measurement& m) {
  t.allow({"kind", "standard_deviation", "minimum", "maximum", "assumed_standard_deviation",
           "assumption"});
  const std::string kind = t.choice("kind", {"standard deviation", "range", "not stated"});
  const auto belongs = [&](std::initializer_list<const char*> keys, bool here) {
    for (const char* key : keys) {
      if (t.has(key) && !here) {
        t.fail(key, fmt::format("does not go with the kind \"{}\"; expected it left out", kind));
      }
    }
  };
  belongs({"standard_deviation"}, kind == "standard deviation");
  belongs({"minimum", "maximum"}, kind == "range");
  belongs({"assumed_standard_deviation", "assumption"}, kind == "not stated");
  if (kind == "standard deviation") {
    m.scatter = ScatterKind::standard_deviation;
    m.standard_deviation = above_zero(t, "standard_deviation", m.unit);
  } else if (kind == "range") {
    m.scatter = ScatterKind::range;
    m.minimum = same_unit(t, "minimum", m.unit);
    m.maximum = same_unit(t, "maximum", m.unit);
    if (m.repeats < 2) t.fail("kind", "is \"range\" of a single repeat; expected repeats >= 2");
    if (!(m.minimum <= m.value && m.value <= m.maximum && m.minimum < m.maximum)) {
      t.fail("maximum", "the value does not lie between minimum and maximum; expected it to");
    }
    m.standard_deviation = (m.maximum - m.minimum) / expected_range(m.repeats);
  } else {
    m.scatter = ScatterKind::not_stated;
    m.standard_deviation = above_zero(t, "assumed_standard_deviation", m.unit);
    m.assumption = t.string("assumption");
    if (m.assumption.empty()) t.fail("assumption", "is empty; expected the reason");
  }
}

void read_reading(const TomlTable& t, Measurement& m) {
  t.allow({"uncertainty", "rationale"});
  m.systematic_uncertainty = above_zero(t, "uncertainty", m.unit);
  m.systematic_rationale = t.string("rationale");
}

std::vector<Criterion> read_criteria(const TomlTable& root) {
  std::vector<Criterion> criteria;
  for (const TomlTable& t : root.tables("criteria")) {
    t.allow({"statement", "lhs", "rhs", "factor", "observed_once_in", "if_run_fails", "rationale"});
    Criterion c;
    c.statement = t.string("statement");
    c.lhs = t.string("lhs");
    c.rhs = t.string("rhs");
    c.factor = t.number("factor", 1);
    c.observed_once_in = t.integer("observed_once_in", 0, 0);
    if (t.has("if_run_fails"))
      c.if_run_fails = t.choice("if_run_fails", {"holds", "does not hold"}) == "holds";
    c.rationale = t.string("rationale");
    c.lhs_place = t.place("lhs");
    c.rhs_place = t.place("rhs");
    for (const char* key : {"statement", "lhs", "rhs", "rationale"})
      if (t.string(key).empty()) t.fail(key, "is empty; expected some words");
    if (!(c.factor > 0)) t.fail("factor", fmt::format("is {}; expected more than zero", c.factor));
    criteria.push_back(c);
  }
  return criteria;
}

// Prose of several lines or with tabs, on one line.
std::string on_one_line(std::string prose) {
  for (char& c : prose)
    if (c == '\n' || c == '\t') c = ' ';
  return prose;
}

MeasurementStatus read_status(const TomlTable& t) {
  const std::string status =
      t.choice("status", {"published", "digitized", "measured", "recorded", "qualitative"});
  if (status == "published") return MeasurementStatus::published;
  if (status == "digitized") return MeasurementStatus::digitized;
  if (status == "measured") return MeasurementStatus::measured;
  return MeasurementStatus::qualitative;
}

// The table [data].
void read_recording(const TomlTable& t, const std::string& directory, Measurement& m) {
  if (t.has("data")) {
    if (m.status != MeasurementStatus::qualitative)
      t.fail("data",
             "go with the status \"recorded\" or \"qualitative\"; expected values in `values`");
    m.data = read_measured_data(t.required_table("data"), directory);
  }
  if (m.recorded && !m.data)
    t.fail("data", "is missing; expected a table [data] with the file of what was recorded");
}

// What was observed or recorded, in words.
void read_statement(const TomlTable& t, Measurement& m) {
  if (m.recorded && !m.data->present)
    t.fail("data", fmt::format("{} does not exist; expected what was recorded", m.data->file));
  for (const char* key : {"value", "values", "repeats", "scatter", "systematic"}) {
    if (t.has(key)) {
      t.fail(key, fmt::format("does not go with the status \"{}\"; expected {}", t.string("status"),
                              m.recorded ? "[data]" : "a statement only"));
    }
  }
  m.statement =
      m.recorded
          ? t.string("statement",
                     "recorded in " + std::filesystem::path(m.data->file).filename().string())
          : t.string("statement");
}

// A number with its scatter, or the repeats that it is the mean of.
void read_value(const TomlTable& t, const std::string& directory, Measurement& m) {
  if (!m.criteria.empty()) {
    t.fail("criteria", "go with the status \"qualitative\" only; expected a value");
  }
  if (t.has("statement")) {
    t.fail("statement", "goes with the status \"qualitative\" only; expected a value");
  }
  m.value_place = t.place(t.has("values") ? "values" : "value");
  if (t.has("values")) {
    read_measured_values(t, directory, m);
  } else {
    const UnitValue value = quantity(t, "value");
    m.value = value.value;
    m.unit = value.unit;
    m.repeats = t.integer("repeats", 1);
    read_scatter(t.required_table("scatter"), m);
  }
  if (t.has("systematic")) read_reading(t.table("systematic"), m);
}

}  // namespace

UnitValue parse_unit_value(const std::string& text) {
  UnitValue q;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), q.value);
  const bool usable = std::abs(q.value) <= usable_range(dimension::none).largest;
  if (error != std::errc() || !usable) {
    throw InputError(fmt::format("\"{}\" is not a quantity; expected {}", text, kQuantity));
  }
  const std::string unit(rest, text.data() + text.size());
  const auto first = unit.find_first_not_of(' ');
  q.unit = first == std::string::npos ? "1" : plain_unit(unit.substr(first));
  if (q.unit != "1") parse_unit(q.unit);
  return q;
}

const char* to_string(MeasurementStatus status) {
  switch (status) {
    case MeasurementStatus::published:
      return "published";
    case MeasurementStatus::digitized:
      return "digitized";
    case MeasurementStatus::measured:
      return "measured";
    case MeasurementStatus::qualitative:
      return "qualitative";
  }
  return "";
}

const char* status_text(const Measurement& measurement) {
  return measurement.recorded ? "recorded" : to_string(measurement.status);
}

double Measurement::standard_uncertainty() const {
  return std::hypot(standard_deviation / std::sqrt(repeats), systematic_uncertainty);
}

double Measurement::widened_uncertainty() const {
  if (scatter == ScatterKind::not_stated || repeats < 2) return standard_uncertainty();
  const double variance = standard_deviation * standard_deviation / repeats;
  return std::hypot(std::sqrt(widened_variance(variance, repeats - 1)), systematic_uncertainty);
}

std::string Measurement::sentence() const {
  if (status == MeasurementStatus::qualitative) return on_one_line(statement);
  std::string text = fmt::format("{} {} (n = {}; standard deviation {} {}",
                                 measured_text(value, standard_uncertainty()), unit, repeats,
                                 number_text(standard_deviation, 3), unit);
  if (scatter == ScatterKind::range) {
    text += fmt::format(", estimated from the range {:.6g} to {:.6g}", minimum, maximum);
  }
  if (!assumption.empty()) text += ", ASSUMED: " + assumption;
  if (systematic_uncertainty > 0) {
    text +=
        fmt::format("; reading {:.2g} {}: {}", systematic_uncertainty, unit, systematic_rationale);
  }
  return on_one_line(text + ")");
}

Measurement read_measurement_text(const std::string& text, const std::string& source) {
  TomlDocument document(text, source, TomlFormat::measurement);
  refuse_other_kinds(document, "a measurement file");
  const TomlTable t = TomlTable::root(document);
  t.allow({"name", "response", "value", "values", "repeats", "status", "statement", "source",
           "experiment", "origin", "apparatus", "notes", "scatter", "systematic", "criteria",
           "data"});
  const std::string directory = std::filesystem::path(source).parent_path().string();
  Measurement m;
  m.file = source;
  m.name = t.string("name");
  m.status = read_status(t);
  m.criteria = read_criteria(t);
  m.recorded = t.string("status") == "recorded";
  read_recording(t, directory, m);
  m.response_place = m.data && !t.has("response") ? m.data->response_place : t.place("response");
  m.response = m.data || !m.criteria.empty() ? t.string("response", m.data ? m.data->response : "")
                                             : t.string("response");
  m.source = t.string("source");
  m.experiment = t.string("experiment", "");
  m.simulated = t.choice("origin", {"experiment", "simulation"}, "experiment") == "simulation";
  m.apparatus = t.string("apparatus", "");
  m.notes = t.string("notes", "");
  if (m.status == MeasurementStatus::qualitative)
    read_statement(t, m);
  else
    read_value(t, directory, m);
  return m;
}

Measurement read_measurement(const std::string& file) {
  return read_measurement_text(
      read_input_file(file, "a measurement file", input_limits::toml_bytes), file);
}

void use_current_responses(Measurement& m) {
  const auto use_current = [](const std::string& place, std::string& text) {
    const std::string current = current_response_name(text);
    if (current != text) warn_of_old_name(place, {"", 0, text, current, false});
    text = current;
  };
  use_current(m.response_place, m.response);
  if (m.data) use_current(m.data->response_place, m.data->response);
  for (Criterion& c : m.criteria) {
    use_current(c.lhs_place, c.lhs);
    use_current(c.rhs_place, c.rhs);
  }
}

double expected_range(int n) {
  assert(n >= 2);
  // Integral of 1 - Phi(x)^n - (1 - Phi(x))^n over all x (Tippett 1925), by the trapezoidal rule:
  // the integrand is smooth and vanishes at both ends.
  constexpr double end = 9, step = 0.01;
  double sum = 0;
  for (double x = -end; x <= end; x += step) {
    const double below = 0.5 * std::erfc(-x / std::sqrt(2.0));
    sum += 1 - std::pow(below, n) - std::pow(1 - below, n);
  }
  return sum * step;
}

}  // namespace firn
