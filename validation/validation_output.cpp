// A validation as text, and as JSON for programs and pages.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "experiments/storage/version.h"
#include "experiments/text/vector_json.h"
#include "firn/contact_model.h"
#include "validation/validate.h"

namespace firn {
namespace {

using Json = nlohmann::ordered_json;

Json numbers(const std::vector<double>& values) {
  Json j = Json::array();
  for (const double v : values) j.push_back(number_json(v));
  return j;
}

Json interval(const Interval& i) { return {number_json(i.low), number_json(i.high)}; }

Json value_json(const ValueComparison& v) {
  Json j = {{"unit", v.unit},
            {"simulated", number_json(v.simulation.mean)},
            {"standard_deviation", number_json(v.simulation.deviation)},
            {"runs", v.simulation.count},
            {"samples", numbers(v.samples)},
            {"measured", number_json(v.measured)},
            {"comparison_error", number_json(v.difference)},
            {"validation_uncertainty", number_json(v.uncertainty)},
            {"expanded_uncertainty", number_json(v.expanded)},
            {"simulated_expanded", number_json(v.simulated_expanded)},
            {"measured_expanded", number_json(v.measured_expanded)},
            {"p_value", number_json(v.p_value)}};
  for (const UncertaintyComponent& p : v.components)
    j["components"].push_back({{"name", p.name},
                               {"value", p.value ? number_json(*p.value) : Json(nullptr)},
                               {"degrees_of_freedom", number_json(p.freedom)},
                               {"evaluation_method", p.evaluation_method}});
  j["area_metric"] = v.area ? interval(*v.area) : Json(nullptr);
  return j;
}

Json criterion_json(const CriterionResult& r) {
  return {{"statement", r.criterion.statement},
          {"relation",
           fmt::format("{} > {}{}", r.criterion.lhs,
                       r.criterion.factor == 1 ? "" : fmt::format("{:g} x ", r.criterion.factor),
                       r.criterion.rhs)},
          {"rationale", r.criterion.rationale},
          {"observed_once_in", r.criterion.observed_once_in},
          {"holds_in", r.holds},
          {"runs", r.runs},
          {"probability_90", interval(r.probability)},
          {"verdict", to_string(r.verdict)},
          {"lhs", numbers(r.lhs)},
          {"rhs", numbers(r.rhs)},
          {"unit", r.unit}};
}

Json distribution_json(const DistributionResult& d) {
  Json j = {{"response", d.response},
            {"unit", d.unit},
            {"by_class", d.by_class},
            {"classes", d.classes},
            {"measured", numbers(d.measured)},
            {"simulated", numbers(d.simulated)},
            {"deviation", numbers(d.deviation)},
            {"verdict", to_string(d.verdict)}};
  for (const auto& [key, of] :
       {std::pair{"measured_passed", CensoredTimes{d.measured, d.measured_at_least}},
        std::pair{"simulated_passed", CensoredTimes{d.simulated, d.simulated_at_least}}}) {
    if (d.by_class || of.inside.empty()) continue;
    const EmpiricalCdf s = kaplan_meier(of);
    j[key] = {{"x", numbers(s.x)},
              {"share", numbers(s.share)},
              {"error", numbers(s.error)},
              {"still_inside", of.inside.size()}};
  }
  if (d.measured.empty()) return j;
  j["distance"] = number_json(d.distance);
  j["p_value"] = number_json(d.p_value);
  j["critical_distance"] = d.critical > 1 ? Json(nullptr) : number_json(d.critical);
  j["dependent"] = d.dependent;
  if (d.by_class) j["dispersion"] = number_json(d.dispersion);
  j["value_apart"] = d.apart ? number_json(*d.apart) : Json(nullptr);
  if (!d.by_class)
    j["area"] = {{"value", number_json(d.area)}, {"p_value", number_json(d.area_p_value)}};
  return j;
}

Json probability_json(const BreakageProbability& p) {
  return {{"each", interval(p.each)},
          {"each_best", number_json(p.each_best)},
          {"any", interval(p.any)},
          {"any_best", number_json(p.any_best)}};
}

Json breakage_json(const BreakageResult& d) {
  return {{"response", d.response},
          {"particles", d.particles},
          {"largest", number_json(d.largest)},
          {"median", number_json(d.median)},
          {"distribution_free", probability_json(d.free)},
          {"weibull", probability_json(d.weibull)},
          {"loads", numbers(d.loads)}};
}

Json stiffness_scaling_json(const StiffnessScalingResult& s) {
  return {{"response", s.response},
          {"unit", s.unit},
          {"modulus", numbers(s.modulus)},
          {"mean", numbers(s.mean)},
          {"error", numbers(s.error)},
          {"runs", s.runs},
          {"exponent", number_json(s.exponent)},
          {"exponent_error", number_json(s.exponent_error)},
          {"extrapolated_95", interval(s.extrapolated)},
          {"extrapolation_factor", number_json(s.extrapolation_factor)},
          {"interpretation", s.interpretation}};
}

Json curve_json(const CurveComparison& c) {
  return {{"x_name", c.x_name},
          {"x_unit", c.x_unit},
          {"y_name", c.y_name},
          {"unit", c.y_unit},
          {"runs", c.runs},
          {"repeats", c.repeats},
          {"x", numbers(c.x)},
          {"measured", numbers(c.measured)},
          {"measured_error", numbers(c.measured_error)},
          {"simulated", numbers(c.simulated)},
          {"simulated_error", numbers(c.simulated_error)},
          {"shift", number_json(c.shift)},
          {"range", number_json(c.range)},
          {"comparison_error", number_json(c.difference)},
          {"validation_uncertainty", number_json(c.uncertainty)},
          {"expanded_uncertainty", number_json(c.expanded)},
          {"largest", number_json(c.largest)},
          {"at", number_json(c.at)}};
}

Json variant_json(const VariantEffect& c) {
  return {{"response", c.response},
          {"unit", c.unit},
          {"variant", c.variant},
          {"seeds", c.seeds},
          {"before", number_json(c.before)},
          {"after", number_json(c.after)},
          {"error", number_json(c.error)}};
}

Json comparison_json(const Comparison& c) {
  Json j = {{"name", c.name},
            {"title", c.title},
            {"note", c.note},
            {"kind", to_string(c.kind)},
            {"experiment", c.experiment},
            {"parameter_set", c.parameter_set},
            {"verdict", to_string(c.verdict)},
            {"headline", c.headline},
            {"recommended_action", c.recommended_action},
            {"measurement", c.measurement},
            {"measurement_status", c.measurement_status},
            {"code_to_code", c.code_to_code},
            {"caveats", c.caveats},
            {"runs", c.runs},
            {"finished", c.finished}};
  for (const AssumptionResult& a : c.assumptions)
    j["assumptions"].push_back({{"name", a.name},
                                {"runs", a.runs},
                                {"outcome", a.outcome},
                                {"changes_the_verdict", a.changes}});
  if (c.value) j["value"] = value_json(*c.value);
  for (const CriterionResult& r : c.criteria) j["criteria"].push_back(criterion_json(r));
  if (c.distribution) j["distribution"] = distribution_json(*c.distribution);
  for (const BreakageResult& d : c.breakage) j["breakage"].push_back(breakage_json(d));
  if (c.strength) {
    const Measurement& m = c.breaking_force;
    j["strength"] = {
        {"minimum", m.minimum}, {"mean", m.value}, {"maximum", m.maximum}, {"tests", m.repeats}};
    j["weibull_shape"] = {{"median", c.strength->shape_median},
                          {"interval_95", interval(c.strength->shape_95)}};
  }
  for (const StiffnessScalingResult& s : c.stiffness_scaling)
    j["stiffness_scaling"].push_back(stiffness_scaling_json(s));
  for (const VariantEffect& r : c.variants) j["numerical_variants"].push_back(variant_json(r));
  if (c.curve) j["curve"] = curve_json(*c.curve);
  return j;
}

Json experiment_json(const Validation& v, std::size_t e) {
  const SuiteExperiment& experiment = v.suite.experiments[e];
  Json j = {{"name", experiment.name}, {"case", experiment.case_file}};
  for (const RunGroup& group : v.groups) {
    if (group.experiment != e) continue;
    for (std::size_t i = 0; i < group.results.size(); ++i) {
      const JobResult& r = group.results[i];
      j["runs"].push_back({{"key", group.keys[i]},
                           {"parameter_set", v.suite.parameter_sets[group.parameter_set].name},
                           {"purpose", to_string(group.purpose)},
                           {"setting", group.setting},
                           {"variant", group.purpose == RunGroup::Purpose::variant
                                           ? experiment.variants[group.variant].name
                                           : ""},
                           {"seed", group.seeds[i]},
                           {"status", to_string(r.status)},
                           {"reason", r.reason},
                           {"wall", r.wall},
                           {"results_file", r.results_file}});
    }
  }
  return j;
}

}  // namespace

std::string render_table(const Validation& v) {
  std::string text = fmt::format("{}\n\n", v.suite.title);
  for (const Comparison& c : v.comparisons) {
    text += fmt::format("{:<24} {} [{}]\n    {}\n", verdict_words(c), c.title, c.parameter_set,
                        c.headline);
    for (const CriterionResult& r : c.criteria)
      text += fmt::format("    {:<22} {} of {} runs: {}\n", to_string(r.verdict), r.holds, r.runs,
                          r.criterion.statement);
    for (const StiffnessScalingResult& s : c.stiffness_scaling)
      text += fmt::format("    {}: {}\n", s.response, s.interpretation);
    for (const VariantEffect& r : c.variants)
      text += fmt::format(
          "    {} with {}: {:.3g} instead of {:.3g} {} (difference ± {:.2g}, {} "
          "seeds)\n",
          r.response, r.variant, r.after, r.before, r.unit, r.error, r.seeds);
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
  Json j = {{"kind", "validation"},
            {"name", v.suite.name},
            {"title", v.suite.title},
            {"note", v.suite.note},
            {"suite_file", v.suite.source},
            {"suite", v.suite.text},
            {"command", v.command},
            {"firn_version", firn_version()},
            {"git_commit", firn_git_commit()},
            {"contact_model", kContactModel}};
  for (const ParameterSet& p : v.suite.parameter_sets) {
    Json set = Json::object();
    for (const auto& [key, value] : p.set) set[key] = value;
    j["parameter_sets"].push_back({{"name", p.name},
                                   {"note", p.note},
                                   {"material", p.material},
                                   {"set", set},
                                   {"samples", p.samples}});
  }
  for (std::size_t e = 0; e < v.suite.experiments.size(); ++e)
    j["experiments"].push_back(experiment_json(v, e));
  for (const Comparison& c : v.comparisons) j["comparisons"].push_back(comparison_json(c));
  return j.dump(1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace firn
