#include "calibrate/study/read_responses.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <set>

#include "calibrate/study/read_parameters.h"
#include "experiments/measurements/bench_tests.h"
#include "experiments/measurements/measurement.h"
#include "experiments/text/number_text.h"
#include "experiments/text/response_aliases.h"
#include "experiments/text/toml_document.h"
#include "experiments/text/toml_names.h"

namespace firn {

std::size_t named_experiment(const TomlTable& t, const Study& study) {
  if (study.experiments.size() == 1 && !t.has("experiment")) return 0;
  const std::string wanted = t.string("experiment");
  for (std::size_t e = 0; e < study.experiments.size(); ++e)
    if (study.experiments[e].name == wanted) return e;
  t.fail("experiment",
         fmt::format("\"{}\" is not an experiment of this study; expected the name of one "
                     "of [[experiments]]",
                     wanted));
}

namespace {

ResponseId response_id(std::size_t experiment, const Study& study, const std::string& name) {
  return {experiment, name,
          study.experiments.size() == 1 ? name : study.experiments[experiment].name + "." + name};
}

// The response that a table names.
ResponseId response_id(const TomlTable& t, const Study& study) {
  const std::size_t e = named_experiment(t, study);
  const std::string name = t.string("response");
  return response_id(e, study,
                     study.experiments[e].is_case() ? current_response(t, "response", name) : name);
}

double read_effort(const TomlTable& t) {
  return t.optional_quantity("effort", dimension::time, Sign::positive).value_or(0);
}

// `like` has the unit that is expected.
void require_unit(const TomlTable& t, const char* key, const StatedQuantity& q,
                  const std::string& unit, const char* like) {
  if (q.unit != unit)
    t.fail(key,
           fmt::format("has the unit \"{}\"; expected \"{}\" as the {} has", q.unit, unit, like));
}

// `of` has the standard deviation.
void require_deviation(const TomlTable& t, const char* key, const StatedQuantity& q,
                       const char* of) {
  if (!(q.value > 0))
    t.fail(key,
           fmt::format("{} is not above 0; expected one standard deviation of {}", q.value, of));
}

// Standard deviation of the simulation's systematic error in a response of this unit; 0: none.
double read_discrepancy(const TomlTable& t, const std::string& unit) {
  if (!t.has("discrepancy")) return 0;
  const StatedQuantity q = read_stated_quantity(t, "discrepancy");
  require_unit(t, "discrepancy", q, unit_text(unit), "value");
  require_deviation(t, "discrepancy", q, "the simulation's systematic error, or no such key");
  return q.value;
}

std::string source_of(const Measurement& m) {
  const double plain = m.standard_uncertainty(), believed = m.widened_uncertainty();
  if (believed == plain) return m.sentence();
  return fmt::format("{}; taken as ± {:.2g} {}, since {} repeats hardly determine their scatter",
                     m.sentence(), believed, m.unit, m.repeats);
}

Measurement named_measurement(const TomlTable& t, const Study& study) {
  const auto file = std::filesystem::path(study.source).parent_path() / t.string("measurement");
  return read_measurement(file.lexically_normal().string());
}

bool is_curve(const Measurement& m) { return m.data && m.data->kind == MeasuredData::Kind::curve; }

// The mean of the repeats of a recorded curve at evenly spaced places where all of them reach.
void set_recorded(const TomlTable& t, const MeasuredData& data, CurveTarget& c) {
  constexpr Eigen::Index places = 100;
  double first = -std::numeric_limits<double>::infinity(), last = -first;
  for (const MeasuredData::Repeat& r : data.repeats) {
    first = std::max(first, *std::min_element(r.x.begin(), r.x.end()));
    last = std::min(last, *std::max_element(r.x.begin(), r.x.end()));
  }
  if (!(first < last) || !std::isfinite(last - first))
    t.fail("measurement", fmt::format("{}: the repeats have no stretch of {} in common; expected "
                                      "one to compare curves over",
                                      data.file, data.x_name));
  c.x = Eigen::VectorXd::LinSpaced(places, first, last);
  c.y = Eigen::VectorXd::Zero(places);
  for (const MeasuredData::Repeat& r : data.repeats)
    c.y += *sampled_curve(r.x, r.y, c.x) / static_cast<double>(data.repeats.size());
}

// A recorded curve, from a measurement file.
CurveTarget curve_target(const TomlTable& t, const Study& study, Measurement m) {
  constexpr int usual_components = 3, most_components = 5;
  t.allow({"measurement", "experiment", "uncertainty", "components", "discrepancy"});
  CurveTarget c;
  c.experiment = named_experiment(t, study);
  if (!study.experiments[c.experiment].is_case())
    t.fail("measurement",
           "is a curve; expected one of an experiment with a case, as programs and "
           "functions give numbers alone");
  if (study.choice)
    t.fail("measurement",
           "is a curve in a study of a parameter with choices; expected targets with a value");
  use_current_responses(m);
  const MeasuredData& data = *m.data;
  if (!data.present)
    t.fail("measurement", fmt::format("{} does not exist; expected what was recorded", data.file));
  if (data.align != MeasuredData::Alignment::none)
    t.fail("measurement", fmt::format("{}: aligns its curves; expected align = \"none\" in [data], "
                                      "as scores need a fixed zero of {}",
                                      m.file, data.x_name));
  c.name = data.response;
  c.label = response_id(c.experiment, study, data.response).label;
  c.unit = data.unit;
  c.x_unit = data.x_unit;
  const StatedQuantity uncertainty = read_stated_quantity(t, "uncertainty");
  require_unit(t, "uncertainty", uncertainty, unit_text(c.unit), "curve");
  require_deviation(t, "uncertainty", uncertainty, "the recorded curve");
  c.uncertainty = uncertainty.value;
  c.discrepancy = read_discrepancy(t, c.unit);
  c.components = t.integer("components", 1, usual_components);
  if (c.components > most_components)
    t.fail("components", fmt::format("is {}; expected at most {}", c.components, most_components));
  set_recorded(t, data, c);
  c.source =
      fmt::format("{}, {} of {} over {}", m.source,
                  data.repeats.size() == 1 ? std::string("one record")
                                           : fmt::format("mean of {} records", data.repeats.size()),
                  data.y_name, data.x_name);
  c.file = m.file;
  return c;
}

// From a measurement file with a value.
Target measured_target(const TomlTable& t, const Study& study, Measurement m) {
  t.allow({"measurement", "response", "experiment", "effort", "discrepancy"});
  const std::size_t e = named_experiment(t, study);
  if (study.experiments[e].is_case()) use_current_responses(m);
  if (m.status == MeasurementStatus::qualitative)
    t.fail("measurement", "is qualitative; expected one with a value to fit to");
  if (!(m.widened_uncertainty() > 0))
    t.fail(
        "measurement",
        fmt::format("{}: its values are identical, so that its uncertainty is zero; expected a "
                    "[reading] with the uncertainty of the instrument (its resolution / sqrt(12))",
                    m.file));
  // Another response may stand for the same measurement: another estimator of the same thing.
  return {t.has("response") ? response_id(t, study) : response_id(e, study, m.response),
          m.value,
          m.widened_uncertainty(),
          m.unit,
          source_of(m),
          read_effort(t),
          m.file,
          read_discrepancy(t, m.unit)};
}

// Given in place.
Target stated_target(const TomlTable& t, const Study& study) {
  t.allow({"response", "value", "uncertainty", "experiment", "effort", "discrepancy"});
  const StatedQuantity value = read_stated_quantity(t, "value"),
                       uncertainty = read_stated_quantity(t, "uncertainty");
  require_unit(t, "uncertainty", uncertainty, value.unit, "value");
  require_deviation(t, "uncertainty", uncertainty, "the measured value");
  const std::string unit = value.unit.empty() ? "1" : value.unit;
  return {response_id(t, study), value.value, uncertainty.value,        unit, "stated in the study",
          read_effort(t),        "",          read_discrepancy(t, unit)};
}

// What a list of bench tests says of measuring this response.
void take_from_list(const TomlTable& t, const std::vector<BenchTest>& list, Observed& o) {
  const std::string name = t.string("bench_test"), current = current_response_name(name);
  for (const BenchTest& test : list)
    for (const BenchResponse& response : test.responses)
      if ((test.name == name || test.name == current) && response.name == o.response.name) {
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
  t.allow({"response", "experiment", "uncertainty", "effort", "bench_test", "discrepancy"});
  Observed o;
  o.response = response_id(t, study);
  if (t.has("bench_test")) {
    if (t.has("uncertainty") || t.has("effort"))
      t.fail("bench_test",
             "is given together with uncertainty or effort; expected one or the other");
    take_from_list(t, list, o);
    o.discrepancy = read_discrepancy(t, o.unit);
    return o;
  }
  if (t.has("uncertainty")) {
    const StatedQuantity q = read_stated_quantity(t, "uncertainty");
    require_deviation(t, "uncertainty", q, "a measured value");
    o.uncertainty = q.value;
    o.unit = q.unit.empty() ? "1" : q.unit;
    o.discrepancy = read_discrepancy(t, o.unit);
  } else if (t.has("discrepancy")) {
    t.fail("discrepancy",
           "is given without an uncertainty; expected the uncertainty of a possible measurement, "
           "since a response that is not measured has no discrepancy");
  }
  o.effort = read_effort(t);
  return o;
}

}  // namespace

void read_responses(const TomlTable& root, const TomlTable& head, Study& study) {
  std::vector<BenchTest> list;
  if (head.has("bench_tests"))
    list = read_bench_tests(
        (std::filesystem::path(study.source).parent_path() / head.string("bench_tests"))
            .lexically_normal()
            .string());
  std::set<std::string> seen;
  for (const TomlTable& t : root.tables("targets")) {
    if (t.has("measurement")) {
      Measurement m = named_measurement(t, study);
      if (is_curve(m)) {
        study.curves.push_back(curve_target(t, study, std::move(m)));
        if (!seen.insert(study.curves.back().label).second)
          t.fail("measurement", fmt::format("\"{}\" is a target twice; expected each curve once",
                                            study.curves.back().label));
        continue;
      }
      study.targets.push_back(measured_target(t, study, std::move(m)));
    } else {
      study.targets.push_back(stated_target(t, study));
    }
    const std::string& label = study.targets.back().response.label;
    if (!seen.insert(label).second)
      t.fail("response",
             fmt::format("\"{}\" is a target twice; expected each response once", label));
  }
  if (study.targets.empty() && study.curves.empty())
    root.fail("targets", "is missing; expected at least one [[targets]] table");
  for (const TomlTable& t : root.tables("observe")) {
    study.observed.push_back(read_observed(t, study, list));
    const std::string& label = study.observed.back().response.label;
    if (!seen.insert(label).second)
      t.fail("response", fmt::format("\"{}\" is named twice; expected each response once", label));
  }
}

}  // namespace firn
