#include "validation/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/batch/operand.h"
#include "experiments/small_samples.h"
#include "validation/softening.h"

namespace firn {
namespace {

// What is seen once must not be all but impossible; what is seen as a rule must be the rule.
constexpr double improbable = 0.05, rule = 0.5;
constexpr double claim_confidence = 0.9;  // 95 % on the side that the verdict looks at

std::string with_unit(double value, const std::string& unit) {
  return unit.empty() || unit == "1" ? fmt::format("{:.3g}", value)
                                     : fmt::format("{:.3g} {}", value, unit);
}

std::vector<double> defined(std::vector<double> values) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  return values;
}

// What a change of numerics does: the difference of the means over the same seeds, or its standard
// error where that is larger: a change that seeds hide is not known to be smaller.
UncertaintyPart numerics_part(const char* name, const RunGroup* changed, const RunGroup& base,
                              const std::string& operand, const std::string& setting) {
  if (changed == nullptr) return {name, std::nullopt, "not looked at"};
  std::vector<double> differences;
  for (std::size_t i = 0; i < changed->results.size(); ++i) {
    const auto seed = std::ranges::find(base.seeds, changed->seeds[i]);
    if (seed == base.seeds.end()) continue;
    const JobResult& before = base.results[static_cast<std::size_t>(seed - base.seeds.begin())];
    const JobResult& after = changed->results[i];
    if (before.status != JobStatus::finished || after.status != JobStatus::finished) continue;
    const Operand o = parse_operand(operand);
    differences.push_back(evaluate(o, after.responses) - evaluate(o, before.responses));
  }
  const SampleFacts f = facts_of(defined(differences));
  if (f.count == 0) return {name, std::nullopt, setting + ": no run finished"};
  if (f.count == 1)
    return {name, std::abs(f.mean),
            fmt::format("{}: changes by {:.3g} in one run", setting, f.mean)};
  const double error = std::sqrt(widened(f.error() * f.error(), f.count - 1));
  return {name, std::max(std::abs(f.mean), error),
          fmt::format("{}: changes by {:.3g} +- {:.2g} over {} seeds", setting, f.mean, error,
                      f.count)};
}

UncertaintyPart seeds_part(const SampleFacts& f) {
  if (f.count < 2) return {"seeds", std::nullopt, "one run tells no scatter"};
  return {"seeds", std::sqrt(widened(f.error() * f.error(), f.count - 1)),
          fmt::format("standard deviation {:.3g} over {} runs", f.deviation, f.count)};
}

// What is left of the scatter over draws from the family when that over seeds is taken out.
UncertaintyPart input_part(const Evidence& e, const std::string& operand, const SampleFacts& base) {
  if (e.input == nullptr)
    return {"input", std::nullopt,
            e.material == nullptr ? "the parameters come without an uncertainty"
                                  : "not sampled from the material's family"};
  const SampleFacts f = facts_of(defined(e.input->values(operand)));
  if (f.count < 2) return {"input", std::nullopt, "fewer than two draws finished"};
  const double seeds = base.count < 2 ? 0 : base.deviation * base.deviation;
  const double variance = std::max(0.0, f.deviation * f.deviation - seeds);
  return {"input", std::sqrt(variance),
          fmt::format("standard deviation {:.3g} over {} draws from the family, of which seeds "
                      "explain {:.3g}",
                      f.deviation, f.count, std::sqrt(seeds))};
}

bool calibrated_to(const MaterialRecord* material, const Measurement& m) {
  if (material == nullptr || m.source.empty()) return false;
  return std::ranges::any_of(material->provenance.measurements, [&](const UsedMeasurement& used) {
    return used.value == m.value && used.unit == m.unit &&
           used.source.find(m.source) != std::string::npos;
  });
}

void require_unit(const std::string& response, const RunGroup& base, const Measurement& m) {
  const Operand o = parse_operand(response);
  for (const JobResult* r : base.finished())
    if (const std::string unit = unit_of(o, r->responses); !unit.empty() && unit != m.unit)
      throw InputError(
          fmt::format("{}: unit: \"{}\" is measured in \"{}\"; expected \"{}\", the "
                      "unit of the response",
                      m.file, response, m.unit, unit));
}

const UncertaintyPart& largest_part(const ValueComparison& v) {
  return *std::ranges::max_element(v.parts, {},
                                   [](const UncertaintyPart& p) { return p.value.value_or(-1); });
}

std::string remedy(const ValueComparison& v) {
  for (const UncertaintyPart& p : v.parts)
    if (p.name == "seeds" && !p.value) return "more than one run";
  const std::string& largest = largest_part(v).name;
  if (largest == "seeds") return "more runs with other seeds: their scatter is the largest part";
  if (largest == "experiment") return "more repeats of the experiment, each value given";
  if (largest == "input")
    return "parameters that are better known: a further bench test in their calibration";
  return fmt::format("a finer {}: it is the largest part", largest);
}

void judge_value(const SuiteComparison& what, Comparison& c) {
  const ValueComparison& v = *c.value;
  const double expanded = 2 * v.uncertainty, off = std::abs(v.difference);
  const bool seeds_known = v.parts.front().value.has_value();
  c.headline = fmt::format(
      "simulated {}, measured {}: {} by {} +- {}", with_unit(v.simulation.mean, v.unit),
      with_unit(v.measured, v.unit), v.difference < 0 ? "lower" : "higher",
      with_unit(off < 1e-9 * std::abs(v.measured) ? 0 : off, v.unit), with_unit(expanded, v.unit));
  if (!seeds_known) {
    c.verdict = ValidationVerdict::not_enough_data;
  } else if (what.tolerance && off + expanded <= *what.tolerance) {
    c.verdict = ValidationVerdict::consistent;
    c.headline += fmt::format(", within {}", with_unit(*what.tolerance, v.unit));
  } else if (off > expanded) {
    c.verdict = ValidationVerdict::inconsistent;
  } else if (what.tolerance && expanded > *what.tolerance) {
    c.verdict = ValidationVerdict::not_enough_data;
    c.headline +=
        fmt::format(", too uncertain to tell within {}", with_unit(*what.tolerance, v.unit));
  } else {
    c.verdict = ValidationVerdict::consistent;
    c.headline +=
        fmt::format("; a difference of {} could hide in this", with_unit(off + expanded, v.unit));
  }
  if (c.verdict == ValidationVerdict::not_enough_data) c.would_decide = remedy(v);
}

void compare_value(const SuiteComparison& what, const Evidence& e, Comparison& c) {
  const Measurement& m = what.measurement;
  const std::string& response = what.responses.front();
  require_unit(response, *e.base, m);
  ValueComparison v;
  v.unit = m.unit;
  const std::vector<double> all = e.base->values(response);
  v.samples = defined(all);
  if (const std::size_t missing = all.size() - v.samples.size(); missing > 0)
    c.caveats.push_back(fmt::format(
        "{} of {} runs did not come to the point where the response is read: the mean is of the "
        "others",
        missing, all.size()));
  v.simulation = facts_of(v.samples);
  v.measured = m.value;
  if (v.samples.empty()) {
    c.headline = "no run gave the response";
    c.would_decide = "runs that finish";
    return;
  }
  const std::string half =
      e.timestep == nullptr ? "" : fmt::format("time step {:.3g} us", e.timestep->setting * 1e6);
  const RunGroup* stiffest = e.stiffness.empty() ? nullptr : e.stiffness.back();
  const std::string stiff =
      stiffest == nullptr ? ""
                          : fmt::format("Young's modulus {:.3g} GPa", stiffest->setting * 1e-9);
  v.parts = {seeds_part(v.simulation),
             numerics_part("time step", e.timestep, *e.numerics_base, response, half),
             numerics_part("stiffness", stiffest, *e.numerics_base, response, stiff),
             input_part(e, response, v.simulation),
             {"experiment", m.believed_uncertainty(), m.sentence()}};
  v.difference = v.simulation.mean - v.measured;
  for (const UncertaintyPart& p : v.parts) {
    v.uncertainty = std::hypot(v.uncertainty, p.value.value_or(0));
    if (!p.value && p.name != "seeds") c.caveats.push_back(fmt::format("{}: {}", p.name, p.how));
  }
  if (const auto band = distribution_of(m)) v.area = area_metric(v.samples, *band);
  c.value = v;
  judge_value(what, c);
  if (calibrated_to(e.material, m)) {
    c.verdict = ValidationVerdict::not_independent;
    c.headline += fmt::format(
        "; but {} was calibrated to this measurement, which therefore cannot "
        "validate it",
        e.material->reference());
    c.would_decide = "another measurement";
  }
}

ValidationVerdict judge_claim(const ClaimResult& r) {
  if (r.runs == 0) return ValidationVerdict::not_enough_data;
  if (r.claim.once_in > 0) {
    // Seen in one trial at least of so many.
    const double trials = r.claim.once_in;
    const auto seen = [&](double p) { return 1 - std::pow(1 - p, trials); };
    if (seen(r.probability.high) < improbable) return ValidationVerdict::inconsistent;
    if (seen(r.probability.low) > improbable) return ValidationVerdict::consistent;
    return ValidationVerdict::not_enough_data;
  }
  if (r.probability.high < rule) return ValidationVerdict::inconsistent;
  if (r.probability.low > rule) return ValidationVerdict::consistent;
  return ValidationVerdict::not_enough_data;
}

// The fewest further runs that could settle the claim if they all come out as most have.
int runs_to_settle(ClaimResult r) {
  if (r.runs == 0) return 1;
  const bool mostly = 2 * r.holds >= r.runs;
  for (int more = 1; more <= 1000; ++more) {
    r.holds += mostly;
    r.probability = binomial_interval(r.holds, ++r.runs, claim_confidence);
    if (judge_claim(r) != ValidationVerdict::not_enough_data) return more;
  }
  return 1000;
}

ClaimResult evaluate_claim(const Claim& claim, const RunGroup& base) {
  ClaimResult r;
  r.claim = claim;
  const Operand larger = parse_operand(claim.larger), than = parse_operand(claim.than);
  for (const JobResult* run : base.finished()) {
    r.larger.push_back(evaluate(larger, run->responses));
    r.than.push_back(evaluate(than, run->responses));
    r.unit = unit_of(larger, run->responses);
    const bool known = !std::isnan(r.larger.back()) && !std::isnan(r.than.back());
    r.runs += known;
    r.holds += known && r.larger.back() > claim.times * r.than.back();
  }
  r.probability = binomial_interval(r.holds, r.runs, claim_confidence);
  r.verdict = judge_claim(r);
  return r;
}

DistributionResult compare_distribution(const MeasuredData& data, const RunGroup& base) {
  DistributionResult d;
  d.response = data.response;
  d.by_class = data.kind == MeasuredData::Kind::classes;
  d.unit = d.by_class ? "1" : data.unit;
  for (const JobResult* run : base.finished()) {
    const auto found = std::ranges::find(run->responses, data.response, &Response::name);
    if (found == run->responses.end() || found->unit != d.unit)
      throw InputError(
          fmt::format("{}: response: \"{}\" in \"{}\" is none of the case's; expected "
                      "one, in its unit",
                      data.file, data.response, d.unit));
    if (d.by_class && found->value.size() != data.counts.size())
      throw InputError(fmt::format("{}: has {} classes; expected {}, as the response \"{}\" has",
                                   data.file, data.counts.size(), found->value.size(),
                                   data.response));
    if (d.by_class) d.simulated.resize(data.counts.size(), 0);
    for (std::size_t i = 0; i < found->value.size(); ++i) {
      if (d.by_class)
        d.simulated[i] += found->value[i];
      else if (std::isfinite(found->value[i]))
        d.simulated.push_back(found->value[i]);
    }
  }
  d.classes = data.classes;
  d.measured = d.by_class ? data.counts : data.values;
  const bool any = std::ranges::any_of(d.simulated, [&](double v) { return !d.by_class || v > 0; });
  if (!any) return d;
  if (d.by_class) {
    d.distance = share_distance(d.simulated, d.measured);
    d.p_value = share_p_value(d.simulated, d.measured);
  } else {
    std::ranges::sort(d.simulated);
    std::ranges::sort(d.measured);
    d.distance = smirnov_distance(d.simulated, d.measured);
    d.p_value = smirnov_p_value(d.simulated, d.measured);
    d.area = wasserstein_distance(d.simulated, d.measured);
    d.area_p_value = permutation_p_value(d.simulated, d.measured, wasserstein_distance, 999);
  }
  d.verdict =
      d.p_value < improbable ? ValidationVerdict::inconsistent : ValidationVerdict::consistent;
  return d;
}

std::string distribution_words(const DistributionResult& d) {
  if (d.verdict == ValidationVerdict::not_enough_data) return "no run gave values";
  return fmt::format("{}: {:.2g} {}, which chance alone exceeds in {:.2g} % of all cases",
                     d.by_class ? "share that would have to be exchanged"
                                : "largest distance of the cumulative distributions",
                     d.distance, d.by_class ? "" : fmt::format("(area {:.3g} {})", d.area, d.unit),
                     100 * d.p_value);
}

void compare_claims(const SuiteComparison& what, const Evidence& e, Comparison& c) {
  int consistent = 0, inconsistent = 0, more = 0;
  for (const Claim& claim : what.measurement.claims) {
    const ClaimResult r = evaluate_claim(claim, *e.base);
    consistent += r.verdict == ValidationVerdict::consistent;
    inconsistent += r.verdict == ValidationVerdict::inconsistent;
    if (r.verdict == ValidationVerdict::not_enough_data) more = std::max(more, runs_to_settle(r));
    c.claims.push_back(r);
  }
  const auto all = static_cast<int>(c.claims.size());
  c.headline = fmt::format(
      "of {} statement{}, {} hold{} in the simulation, {} do{} not, {} stay{} "
      "open",
      all, all == 1 ? "" : "s", consistent, consistent == 1 ? "s" : "", inconsistent,
      inconsistent == 1 ? "es" : "", all - consistent - inconsistent,
      all - consistent - inconsistent == 1 ? "s" : "");
  c.verdict = inconsistent > 0    ? ValidationVerdict::inconsistent
              : consistent == all ? ValidationVerdict::consistent
                                  : ValidationVerdict::not_enough_data;
  if (const auto& data = what.measurement.data; data && data->present) {
    c.distribution = compare_distribution(*data, *e.base);
    c.headline += "; " + distribution_words(*c.distribution);
    if (c.distribution->verdict == ValidationVerdict::inconsistent)
      c.verdict = ValidationVerdict::inconsistent;
  } else if (data) {
    c.caveats.push_back(
        fmt::format("the experiment's numbers are not here; as {} they would be "
                    "compared",
                    data->file));
  }
  if (more > 0)
    c.would_decide =
        fmt::format("at least {} more run{} with other seeds", more, more == 1 ? "" : "s");
}

std::vector<std::vector<double>> loads_by_run(const RunGroup& base, const std::string& response) {
  std::vector<std::vector<double>> runs;
  for (const JobResult* run : base.finished()) {
    const auto found = std::ranges::find(run->responses, response, &Response::name);
    if (found == run->responses.end())
      throw InputError(
          fmt::format("\"{}\" is no response of the case; expected loads, one value a "
                      "particle, such as \"opposed_loads\"",
                      response));
    runs.push_back(defined(found->value));
  }
  return runs;
}

void compare_damage(const SuiteComparison& what, const Evidence& e, Comparison& c) {
  if (e.base->finished().empty()) {
    c.headline = "no run finished";
    c.would_decide = "runs that finish";
    return;
  }
  c.strength = fit_weibull(what.measurement);
  c.breaking_force = what.measurement;
  for (const std::string& response : what.responses) {
    require_unit("max " + response, *e.base, what.measurement);
    const auto runs = loads_by_run(*e.base, response);
    DamageResult d;
    d.response = response;
    for (const auto& run : runs) d.loads.insert(d.loads.end(), run.begin(), run.end());
    if (d.loads.empty()) throw InputError(fmt::format("\"{}\" has no values in any run", response));
    std::ranges::sort(d.loads);
    d.particles = static_cast<int>(d.loads.size());
    d.largest = d.loads.back();
    d.median = d.loads[(d.loads.size() - 1) / 2];
    d.free = damage_without_assumption(runs, what.measurement);
    d.weibull = damage_if_weibull(runs, *c.strength);
    c.damage.push_back(d);
  }
  // The first of the responses is the one to be judged by.
  const DamageResult& d = c.damage.front();
  const bool some = d.free.any.low > improbable, none = d.free.any.high < improbable;
  c.headline = fmt::format(
      "largest of {} loads {:.3g} N, weakest of {} tests {:.4g} N; at least one particle of a run "
      "is damaged with a probability of {:.2g} to {:.2g} whatever the distribution of strengths, "
      "{:.2g} ({:.2g} to {:.2g}) if it is Weibull's",
      d.particles, d.largest, what.measurement.repeats, what.measurement.minimum, d.free.any.low,
      d.free.any.high, d.weibull.any_best, d.weibull.any.low, d.weibull.any.high);
  if (some || none)
    c.verdict = some == what.expects_damage ? ValidationVerdict::consistent
                                            : ValidationVerdict::inconsistent;
  else
    c.would_decide = fmt::format(
        "breaking tests in the direction in which the auger presses: {} leave open "
        "whether {:.0f} % of all cubes break below the smallest force seen",
        what.measurement.repeats, 100 * distribution_band_width(what.measurement.repeats));
}

}  // namespace

const char* to_string(ValidationVerdict verdict) {
  switch (verdict) {
    case ValidationVerdict::consistent:
      return "consistent";
    case ValidationVerdict::inconsistent:
      return "inconsistent";
    case ValidationVerdict::not_enough_data:
      return "not enough data to say";
    case ValidationVerdict::not_independent:
      return "not independent";
    case ValidationVerdict::information:
      return "information";
  }
  return "";
}

const char* to_string(RunGroup::Purpose purpose) {
  switch (purpose) {
    case RunGroup::Purpose::base:
      return "base";
    case RunGroup::Purpose::input:
      return "input";
    case RunGroup::Purpose::timestep:
      return "time step";
    case RunGroup::Purpose::stiffness:
      return "stiffness";
  }
  return "";
}

std::vector<const JobResult*> RunGroup::finished() const {
  std::vector<const JobResult*> all;
  for (const JobResult& r : results)
    if (r.status == JobStatus::finished) all.push_back(&r);
  return all;
}

std::vector<double> RunGroup::values(const std::string& text) const {
  const Operand operand = parse_operand(text);
  std::vector<double> all;
  for (const JobResult* r : finished()) all.push_back(evaluate(operand, r->responses));
  return all;
}

Comparison compare(const Suite& suite, const SuiteComparison& what, const ParameterSet& parameters,
                   const Evidence& e) {
  Comparison c;
  c.name = what.name;
  c.title = what.title;
  c.note = what.note;
  c.kind = what.kind;
  c.experiment = suite.experiments[what.experiment].name;
  c.parameter_set = parameters.name;
  if (what.kind != ComparisonKind::softening) {
    c.measurement = what.measurement.sentence() + "; " + what.measurement.source;
    c.measurement_status = to_string(what.measurement.status);
  }
  c.runs = static_cast<int>(e.base->results.size());
  c.finished = static_cast<int>(e.base->finished().size());
  for (const JobResult& r : e.base->results)
    if (r.status != JobStatus::finished)
      c.caveats.push_back(fmt::format("a run is {}: {}", to_string(r.status), r.reason));
  switch (what.kind) {
    case ComparisonKind::value:
      compare_value(what, e, c);
      break;
    case ComparisonKind::claims:
      compare_claims(what, e, c);
      break;
    case ComparisonKind::damage:
      compare_damage(what, e, c);
      break;
    case ComparisonKind::softening:
      c.verdict = ValidationVerdict::information;
      for (const std::string& response : what.responses)
        c.softening.push_back(soften(response, e, what.real_modulus));
      c.headline = softening_headline(c.softening, what.real_modulus);
      break;
  }
  return c;
}

}  // namespace firn
