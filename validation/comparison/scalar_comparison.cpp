// A number against a number.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "experiments/responses/response_expression.h"
#include "experiments/text/number_text.h"
#include "validation/comparison/comparison_kinds.h"
#include "validation/statistics/distributions.h"
#include "validation/statistics/estimated_variance.h"
#include "validation/statistics/grid_convergence.h"
#include "validation/statistics/outlier_test.h"

namespace firn::comparison {
namespace {

// What a change of numerics does: the difference of the means over the same seeds, or its standard
// error where that is larger: a change that seeds hide is not known to be smaller.
UncertaintyComponent numerics_component(const std::string& name, const RunGroup* changed,
                                        const RunGroup& base, const std::string& operand) {
  if (changed == nullptr) return {name, std::nullopt, "not examined"};
  const std::string setting =
      changed->purpose == RunGroup::Purpose::variant ? name : describe_setting(*changed);
  const Change c = change_between(base, *changed, operand);
  const double difference = c.after - c.before;
  if (c.seeds == 0) return {name, std::nullopt, setting + ": no run finished"};
  if (c.seeds == 1)
    return {name, std::abs(difference),
            fmt::format("{}: changes by {} in one run", setting, number_text(difference, 3))};
  const bool hidden = c.error > std::abs(difference);
  UncertaintyComponent part = {name, std::max(std::abs(difference), c.error),
                               fmt::format("{}: changes by {} over {} seeds", setting,
                                           measured_text(difference, c.error), c.seeds)};
  if (hidden) part.freedom = c.seeds - 1;
  return part;
}

// Uncertainty by the time step. Of three time steps, it is estimated from the observed order of
// convergence.
UncertaintyComponent timestep_component(const ComparisonRuns& e, const std::string& operand) {
  if (e.timesteps.size() < 2)
    return numerics_component("time step", e.timestep, *e.numerics_base, operand);
  const RunGroup& medium = **(e.timesteps.end() - 2);
  const Change first = change_between(*e.numerics_base, medium, operand);
  const Change last = change_between(medium, *e.timestep, operand);
  const Change all = change_between(*e.numerics_base, *e.timestep, operand);
  if (e.timesteps.size() > 2 || first.seeds < 2 || last.seeds != first.seeds ||
      all.seeds != first.seeds)
    return numerics_component("time step", e.timestep, *e.numerics_base, operand);
  const Convergence c = converge(
      {first.before, first.after, all.after, medium.setting / e.timestep->setting, last.error});
  return {
      "time step", c.uncertainty,
      fmt::format("{} and {}: {}", describe_setting(medium), describe_setting(*e.timestep), c.how)};
}

// Uncertainty by an assumed input, from runs at an end of its range. A uniform distribution over
// the range gives the factor 1/sqrt(3).
UncertaintyComponent assumption_component(const ComparisonRuns::Other& other, const RunGroup& base,
                                          const std::string& operand) {
  UncertaintyComponent p = numerics_component(other.what->name, other.runs, base, operand);
  if (p.value && std::isinf(p.freedom)) *p.value /= std::sqrt(3.0);
  p.evaluation_method += "; an assumption";
  return p;
}

constexpr const char* kRunVariability = "run-to-run variability";
constexpr const char* kInputParameters = "input parameters";

UncertaintyComponent run_variability_component(const SampleStatistics& f) {
  if (f.count < 2) return {kRunVariability, std::nullopt, "one run gives no scatter"};
  return {kRunVariability, f.error(),
          fmt::format("standard deviation {:.3g} over {} runs", f.deviation, f.count),
          static_cast<double>(f.count - 1)};
}

// Standard deviation over draws from the posterior ensemble, less the variance over seeds.
UncertaintyComponent input_component(const ComparisonRuns& e, const SampleStatistics& draws,
                                     const SampleStatistics& base) {
  if (e.input == nullptr)
    return {kInputParameters, std::nullopt,
            e.material == nullptr ? "the parameters come without an uncertainty"
                                  : "not sampled from the material's posterior ensemble"};
  if (draws.count < 2) return {kInputParameters, std::nullopt, "fewer than two draws finished"};
  const double seeds = base.count < 2 ? 0 : base.deviation * base.deviation;
  const double variance = std::max(0.0, draws.deviation * draws.deviation - seeds);
  return {kInputParameters, std::sqrt(variance),
          fmt::format(
              "standard deviation {:.3g} over {} draws from the posterior ensemble, of which seeds "
              "explain {:.3g}",
              draws.deviation, draws.count, std::sqrt(seeds)),
          static_cast<double>(draws.count - 1)};
}

// Degrees of freedom of a standard deviation that was estimated from repeats: a range of up to ten
// has nine tenths of those of the values themselves.
double freedom_of(const Measurement& m) {
  if (m.scatter == ScatterKind::not_stated || m.repeats < 2)
    return std::numeric_limits<double>::infinity();
  return (m.scatter == ScatterKind::range ? 0.9 : 1.0) * (m.repeats - 1);
}

void add_experiment(const Measurement& m, Noise& noise) {
  noise.add({m.standard_deviation * m.standard_deviation, freedom_of(m)}, 1.0 / m.repeats);
  noise.add({m.systematic_uncertainty * m.systematic_uncertainty});
}

// Adds the uncertainty components. The scatter of seeds is part of the scatter of draws, and is
// subtracted from it; all other components are independent.
void add_simulation(const ValueComparison& v, const SampleStatistics& draws, Noise& noise) {
  const SampleStatistics& base = v.simulation;
  std::optional<std::size_t> seeds;
  if (base.count > 1)
    seeds = noise.add({base.deviation * base.deviation, base.count - 1.0}, 1.0 / base.count);
  for (const UncertaintyComponent& p : v.components) {
    if (!p.value || p.name == kRunVariability || p.name == "experiment") continue;
    if (p.name != kInputParameters) {
      noise.add({*p.value * *p.value, p.freedom});
      continue;
    }
    const std::size_t index = noise.add({draws.deviation * draws.deviation, draws.count - 1.0});
    if (seeds) noise.terms.back() = {{index, 1}, {*seeds, -1}};
  }
}

const UncertaintyComponent& largest_component(const ValueComparison& v) {
  return *std::ranges::max_element(
      v.components, {}, [](const UncertaintyComponent& p) { return p.value.value_or(-1); });
}

std::string value_remedy(const ValueComparison& v) {
  for (const UncertaintyComponent& p : v.components)
    if (p.name == kRunVariability && !p.value) return "more than one run";
  const std::string& largest = largest_component(v).name;
  if (largest == kRunVariability)
    return "more runs with other seeds: their scatter is the largest part";
  if (largest == "experiment") return "more repeats of the experiment, each value given";
  if (largest == kInputParameters)
    return "parameters that are better known: a further bench test in their calibration";
  if (largest == "time step") return "a finer time step: it is the largest part";
  return fmt::format("finer numerics: \"{}\" is the largest part", largest);
}

void judge_value(const SuiteComparison& what, Comparison& c) {
  const ValueComparison& v = *c.value;
  const double expanded = v.expanded, off = std::abs(v.difference);
  const bool seeds_known = v.components.front().value.has_value();
  c.headline =
      fmt::format("simulated {}, measured {}: {} by {}", rounded_text(v.simulation.mean, v.unit),
                  rounded_text(v.measured, v.unit), v.difference < 0 ? "lower" : "higher",
                  measured_text(off < 1e-9 * std::abs(v.measured) ? 0 : off, expanded, v.unit));
  if (!seeds_known) {
    c.verdict = ValidationVerdict::inconclusive;
  } else if (what.tolerance && off + expanded <= *what.tolerance) {
    c.verdict = ValidationVerdict::consistent;
    c.headline += fmt::format(", within {}", rounded_text(*what.tolerance, v.unit));
  } else if (off > expanded) {
    c.verdict = ValidationVerdict::inconsistent;
  } else if (what.tolerance && expanded > *what.tolerance) {
    c.verdict = ValidationVerdict::inconclusive;
    c.headline += fmt::format(", too uncertain for a decision within {}",
                              rounded_text(*what.tolerance, v.unit));
  } else if (!what.tolerance && v.measured != 0 && expanded > std::abs(v.measured)) {
    // The comparison could not find a difference as large as the measured value.
    c.verdict = ValidationVerdict::inconclusive;
    c.headline += ", which is more than the measured value itself";
  } else {
    c.verdict = ValidationVerdict::consistent;
    c.headline += fmt::format("; a difference of {} could hide in this",
                              rounded_text(off + expanded, v.unit));
  }
  if (c.verdict == ValidationVerdict::inconclusive) c.recommended_action = value_remedy(v);
  if (c.verdict != ValidationVerdict::consistent) return;
  for (const auto& [values, whose] :
       {std::pair{&what.measurement.values, "measured"}, std::pair{&v.samples, "simulated"}})
    if (const auto apart = value_apart(*values)) {
      c.verdict = ValidationVerdict::inconclusive;
      c.headline += fmt::format("; the {} value {} stands apart from all other ones", whose,
                                rounded_text(*apart, v.unit));
      c.recommended_action = fmt::format("why one value is {}", rounded_text(*apart, v.unit));
    }
}

}  // namespace

void compare_value(const SuiteComparison& what, const ComparisonRuns& e, Comparison& c) {
  const Measurement& m = what.measurement;
  const std::string& response = what.responses.front();
  require_unit(response, *e.base, m);
  ValueComparison v;
  v.unit = m.unit;
  const std::vector<double> all =
      with_place(what.response_place(0), [&] { return e.base->values(response); });
  v.samples = defined(all);
  if (const std::size_t missing = all.size() - v.samples.size(); missing > 0)
    c.caveats.push_back(fmt::format(
        "{} of {} runs did not come to the point where the response is read: the mean is of the "
        "others",
        missing, all.size()));
  v.simulation = sample_statistics(v.samples);
  v.measured = m.value;
  if (v.samples.empty()) {
    c.headline = "no run gave the response";
    c.recommended_action = "runs that finish";
    return;
  }
  const SampleStatistics draws = e.input == nullptr
                                     ? SampleStatistics{}
                                     : sample_statistics(defined(e.input->values(response)));
  const RunGroup* stiffest = e.stiffness.empty() ? nullptr : e.stiffness.back();
  v.components = {run_variability_component(v.simulation),
                  timestep_component(e, response),
                  numerics_component("stiffness", stiffest, *e.numerics_base, response),
                  input_component(e, draws, v.simulation),
                  {"experiment", m.standard_uncertainty(), m.sentence(), freedom_of(m)}};
  for (const ComparisonRuns::Other& other : e.variants)
    if (other.what->numerics)
      v.components.push_back(
          numerics_component(other.what->name, other.runs, *e.numerics_base, response));
    else if (other.what->assumed)
      v.components.push_back(assumption_component(other, *e.numerics_base, response));
  v.difference = v.simulation.mean - v.measured;
  for (const UncertaintyComponent& p : v.components) {
    v.uncertainty = std::hypot(v.uncertainty, p.value.value_or(0));
    if (!p.value && p.name != kRunVariability)
      c.caveats.push_back(fmt::format("{}: {}", p.name, p.evaluation_method));
  }
  Noise simulation, experiment, both;
  add_simulation(v, draws, simulation);
  add_experiment(m, experiment);
  add_simulation(v, draws, both);
  add_experiment(m, both);
  v.simulated_expanded = expanded_uncertainty(simulation);
  v.measured_expanded = expanded_uncertainty(experiment);
  v.expanded = expanded_uncertainty(both);
  v.p_value = exceedance(both, std::abs(v.difference));
  if (const auto band = with_place(m.value_place, [&] { return distribution_of(m); }))
    v.area = area_metric(v.samples, *band);
  c.value = v;
  judge_value(what, c);
}

}  // namespace firn::comparison
