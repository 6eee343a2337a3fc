// A validation as text, and as JSON for programs and pages.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/storage/version.h"
#include "experiments/text/number_text.h"
#include "firn/contact_model.h"
#include "validation/validate.h"
#include "validation/validation_document.h"

namespace firn {
namespace {

using Document = ValidationDocument;

Document::Interval ends_of(const Interval& i) { return {i.low, i.high}; }

Document::Value value_of(const ValueComparison& v) {
  Document::Value d;
  d.unit = v.unit;
  d.simulated = v.simulation.mean;
  d.standard_deviation = v.simulation.deviation;
  d.runs = static_cast<int>(v.simulation.count);
  d.samples = v.samples;
  d.measured = v.measured;
  d.comparison_error = v.difference;
  d.validation_uncertainty = v.uncertainty;
  d.expanded_uncertainty = v.expanded;
  d.simulated_expanded = v.simulated_expanded;
  d.measured_expanded = v.measured_expanded;
  d.p_value = v.p_value;
  for (const UncertaintyComponent& p : v.components)
    d.components.push_back(
        {p.name, p.value.value_or(std::nan("")), p.freedom, p.evaluation_method});
  if (v.area) d.area_metric = ends_of(*v.area);
  return d;
}

Document::CriterionRow criterion_of(const CriterionResult& r) {
  return {r.criterion.statement,
          fmt::format("{} > {}{}", r.criterion.lhs,
                      r.criterion.factor == 1 ? "" : fmt::format("{:g} x ", r.criterion.factor),
                      r.criterion.rhs),
          r.criterion.rationale,
          r.criterion.observed_once_in,
          r.holds,
          r.runs,
          r.failed,
          r.missing,
          ends_of(r.probability),
          to_string(r.verdict),
          r.lhs,
          r.rhs,
          r.unit};
}

std::optional<Document::Passed> passed_of(const std::vector<double>& times,
                                          const std::vector<double>& at_least, bool by_class) {
  if (by_class || at_least.empty()) return std::nullopt;
  const EmpiricalCdf s = kaplan_meier({times, at_least});
  return Document::Passed{s.x, s.share, s.error, at_least.size()};
}

Document::Distribution distribution_of(const DistributionResult& r) {
  Document::Distribution d;
  d.response = r.response;
  d.unit = r.unit;
  d.by_class = r.by_class;
  d.classes = r.classes;
  d.measured = r.measured;
  d.simulated = r.simulated;
  d.deviation = r.deviation;
  d.verdict = to_string(r.verdict);
  d.measured_passed = passed_of(r.measured, r.measured_at_least, r.by_class);
  d.simulated_passed = passed_of(r.simulated, r.simulated_at_least, r.by_class);
  if (r.measured.empty()) return d;
  d.distance = r.distance;
  d.p_value = r.p_value;
  d.critical_distance = r.critical > 1 ? std::nan("") : r.critical;
  d.dependent = r.dependent;
  if (r.by_class) d.dispersion = r.dispersion;
  d.value_apart = r.apart.value_or(std::nan(""));
  if (!r.by_class) d.area = {r.area, r.area_p_value};
  return d;
}

Document::Probability probability_of(const BreakageProbability& p) {
  return {ends_of(p.each), p.each_best, ends_of(p.any), p.any_best};
}

Document::Curve curve_of(const CurveComparison& c) {
  return {c.x_name,          c.x_unit,  c.y_name,   c.y_unit,         c.runs,
          c.repeats,         c.x,       c.measured, c.measured_error, c.simulated,
          c.simulated_error, c.shift,   c.range,    c.difference,     c.uncertainty,
          c.expanded,        c.largest, c.at};
}

Document::ComparisonRow comparison_of(const Comparison& c) {
  Document::ComparisonRow d;
  d.name = c.name;
  d.title = c.title;
  d.note = c.note;
  d.kind = to_string(c.kind);
  d.experiment = c.experiment;
  d.parameter_set = c.parameter_set;
  d.verdict = to_string(c.verdict);
  d.headline = c.headline;
  d.recommended_action = c.recommended_action;
  d.measurement = c.measurement;
  d.measurement_status = c.measurement_status;
  d.code_to_code = c.code_to_code;
  d.caveats = c.caveats;
  d.runs = c.runs;
  d.finished = c.finished;
  for (const AssumptionResult& a : c.assumptions)
    d.assumptions.push_back({a.name, a.runs, a.outcome, a.changes});
  if (c.value) d.value = value_of(*c.value);
  for (const CriterionResult& r : c.criteria) d.criteria.push_back(criterion_of(r));
  if (c.distribution) d.distribution = distribution_of(*c.distribution);
  for (const BreakageResult& b : c.breakage)
    d.breakage.push_back({b.response, b.particles, b.largest, b.median, probability_of(b.free),
                          probability_of(b.weibull), b.loads});
  if (c.strength) {
    const Measurement& m = c.breaking_force;
    d.strength = {m.minimum, m.value, m.maximum, m.repeats};
    d.weibull_shape = {c.strength->shape_median, ends_of(c.strength->shape_95)};
  }
  for (const StiffnessScalingResult& s : c.stiffness_scaling)
    d.stiffness_scaling.push_back({s.response, s.unit, s.modulus, s.mean, s.error, s.runs,
                                   s.exponent, s.exponent_error, ends_of(s.extrapolated),
                                   s.extrapolation_factor, s.interpretation});
  for (const VariantEffect& r : c.variants)
    d.numerical_variants.push_back(
        {r.response, r.unit, r.variant, r.seeds, r.before, r.after, r.error});
  if (c.curve) d.curve = curve_of(*c.curve);
  return d;
}

Document::ExperimentRow experiment_of(const Validation& v, std::size_t e) {
  const SuiteExperiment& experiment = v.suite.experiments[e];
  Document::ExperimentRow d{experiment.name, experiment.case_file, {}};
  for (const RunGroup& group : v.groups) {
    if (group.experiment != e) continue;
    for (std::size_t i = 0; i < group.results.size(); ++i) {
      const JobResult& r = group.results[i];
      d.runs.push_back({group.keys[i], v.suite.parameter_sets[group.parameter_set].name,
                        to_string(group.purpose), group.setting,
                        group.purpose == RunGroup::Purpose::variant
                            ? experiment.variants[group.number].name
                            : "",
                        group.seeds[i], to_string(r.status), r.reason, r.wall, r.results_file});
    }
  }
  return d;
}

// What a change of numerics does to a response.
std::string variant_line(const VariantEffect& r) {
  const double scale = std::max(std::abs(r.before), std::abs(r.after));
  const auto value = [&](double mean) {
    return number_text(without_rounding_error(mean, scale), 3);
  };
  return fmt::format("    {} with {}: {} instead of {}{} (difference {}, {} seed{})\n", r.response,
                     r.variant, value(r.after), value(r.before), unit_suffix(r.unit),
                     measured_text(without_rounding_error(r.after - r.before, scale), r.error),
                     r.seeds, r.seeds == 1 ? "" : "s");
}

}  // namespace

std::string render_table(const Validation& v) {
  std::string text = fmt::format("{}\n\n", v.suite.title);
  for (const Comparison& c : v.comparisons) {
    text += fmt::format("{:<24} {} [{}]\n    {}\n", verdict_words(c), c.title, c.parameter_set,
                        c.headline);
    for (const CriterionResult& r : c.criteria)
      text += fmt::format("    {:<22} {} of {} runs{}: {}\n", to_string(r.verdict), r.holds, r.runs,
                          r.missing > 0 ? fmt::format(", {} without an answer", r.missing) : "",
                          r.criterion.statement);
    for (const StiffnessScalingResult& s : c.stiffness_scaling)
      text += fmt::format("    {}: {}\n", s.response, s.interpretation);
    for (const VariantEffect& r : c.variants) text += variant_line(r);
    for (const AssumptionResult& a : c.assumptions)
      text +=
          fmt::format("    with {}{}: {}\n", a.name, a.changes ? " (it changes)" : "", a.outcome);
    if (!c.recommended_action.empty())
      text += fmt::format("    recommended: {}\n", c.recommended_action);
    for (const std::string& caveat : c.caveats) text += fmt::format("    note: {}\n", caveat);
  }
  text += '\n';
  for (const auto verdict : {ValidationVerdict::consistent, ValidationVerdict::inconsistent,
                             ValidationVerdict::inconclusive, ValidationVerdict::not_independent,
                             ValidationVerdict::not_comparable})
    if (v.count(verdict) > 0)
      text += fmt::format("{:>4} {}\n", v.count(verdict), to_string(verdict));
  if (const auto codes = std::ranges::count(v.comparisons, true, &Comparison::code_to_code);
      codes > 0)
    text +=
        fmt::format("{:>4} compared with another simulation (code-to-code), not counted\n", codes);
  return text;
}

std::string render_json(const Validation& v) {
  ValidationDocument d;
  d.name = v.suite.name;
  d.title = v.suite.title;
  d.note = v.suite.note;
  d.suite_file = v.suite.source;
  d.suite = v.suite.text;
  d.command = v.command;
  d.firn_version = firn_version();
  d.git_commit = firn_git_commit();
  d.contact_model = kContactModel;
  for (const ParameterSet& p : v.suite.parameter_sets)
    d.parameter_sets.push_back({p.name, p.note, p.material, p.set, p.samples});
  for (std::size_t e = 0; e < v.suite.experiments.size(); ++e)
    d.experiments.push_back(experiment_of(v, e));
  for (const Comparison& c : v.comparisons) d.comparisons.push_back(comparison_of(c));
  return json_text(std::move(d), 1);
}

ValidationDocument read_validation_document(const ResultsJson& results) {
  return document_from_results<ValidationDocument>(results, "validation", "firn validate");
}

}  // namespace firn
