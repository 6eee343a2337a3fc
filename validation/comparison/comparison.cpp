#include "validation/comparison/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/responses/response_expression.h"
#include "experiments/system/value_place.h"
#include "experiments/text/number_text.h"
#include "validation/comparison/comparison_kinds.h"
#include "validation/comparison/data_provenance.h"
#include "validation/comparison/stiffness_scaling.h"

namespace firn {
namespace comparison {

std::string rounded_text(double value, const std::string& unit) {
  return fmt::format("{:.3g}{}", resolved(value, unit), unit_suffix(unit));
}

std::vector<double> defined(std::vector<double> values) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  return values;
}

bool too_many_missing(std::size_t missing, std::size_t all) {
  return static_cast<double>(missing) > missing_limit * static_cast<double>(all);
}

std::string missing_words(const RunGroup& base, std::size_t missing) {
  return fmt::format("{} of {} runs gave no result, and what they would have given is not known",
                     missing, base.results.size());
}

void require_unit(const std::string& response, const RunGroup& base, const Measurement& m) {
  const ResponseExpression o = parse_response_expression(response);
  for (const JobResult* r : base.finished())
    if (const std::string unit = unit_of(o, r->responses); !unit.empty() && unit != m.unit)
      throw InputError(
          fmt::format("{}: \"{}\" is measured in \"{}\"; expected \"{}\", the unit of the response",
                      place_or_file(m.value_place, m.file), response, m.unit, unit));
}

std::string describe_setting(const RunGroup& group) {
  return group.purpose == RunGroup::Purpose::timestep
             ? fmt::format("time step {:.3g} us", group.setting * 1e6)
             : fmt::format("Young's modulus {:.3g} GPa", group.setting * 1e-9);
}

Change change_between(const RunGroup& base, const RunGroup& changed, const std::string& operand) {
  const ResponseExpression o = parse_response_expression(operand);
  std::vector<double> before, after, difference;
  for (std::size_t i = 0; i < changed.results.size(); ++i) {
    const auto seed = std::ranges::find(base.seeds, changed.seeds[i]);
    if (seed == base.seeds.end()) continue;
    const JobResult& b = base.results[static_cast<std::size_t>(seed - base.seeds.begin())];
    const JobResult& a = changed.results[i];
    if (b.status != JobStatus::finished || a.status != JobStatus::finished) continue;
    const double was = evaluate(o, b.responses), is = evaluate(o, a.responses);
    if (!std::isfinite(was) || !std::isfinite(is)) continue;
    before.push_back(was);
    after.push_back(is);
    difference.push_back(is - was);
  }
  Change c;
  c.seeds = static_cast<int>(difference.size());
  if (c.seeds == 0) return c;
  c.before = sample_statistics(before).mean;
  c.after = sample_statistics(after).mean;
  const SampleStatistics f = sample_statistics(difference);
  c.error = f.error();
  return c;
}

}  // namespace comparison

namespace {

// What inputs were chosen with these data, as a clause; empty: none that is known.
std::string chosen_with(const Suite& suite, const SuiteComparison& what, const ComparisonRuns& e) {
  const DataIdentity mine = identity_of(what.measurement, what.responses);
  const auto calibrated = [&](const MaterialRecord& record, const char* how) -> std::string {
    for (const UsedMeasurement& used : record.provenance.measurements)
      if (const auto why = same_data(mine, identity_of(used)))
        return fmt::format("{}{} was calibrated to this measurement ({})", how, record.reference(),
                           *why);
    return {};
  };
  if (e.material != nullptr)
    if (std::string found = calibrated(*e.material, ""); !found.empty()) return found;
  for (const MaterialRecord* record : e.same_values)
    if (std::string found = calibrated(*record, "the case has the values of a record: ");
        !found.empty())
      return found;
  for (const Chosen& chosen : suite.chosen)
    if (chosen.belongs_to(suite.experiments[what.experiment]))
      if (const auto why = same_data(mine, identity_of(chosen.with, {})))
        return fmt::format("{} was chosen with this measurement ({})", chosen.what, *why);
  return {};
}

void judge_independence(const Suite& suite, const SuiteComparison& what, const ComparisonRuns& e,
                        Comparison& c) {
  if (const std::string found = chosen_with(suite, what, e); !found.empty()) {
    c.verdict = ValidationVerdict::not_independent;
    c.headline += fmt::format("; but {}, which therefore cannot validate it", found);
    c.recommended_action = "another measurement";
  } else if (!what.calibrated_by_design.empty()) {
    c.verdict = ValidationVerdict::not_independent;
    c.headline +=
        fmt::format("; but {}: an input, which validates nothing", what.calibrated_by_design);
    c.recommended_action.clear();
  }
}

}  // namespace

std::string verdict_words(const Comparison& c) {
  return std::string(to_string(c.verdict)) + (c.code_to_code ? " (code-to-code)" : "");
}

const char* to_string(ValidationVerdict verdict) {
  switch (verdict) {
    case ValidationVerdict::consistent:
      return "consistent";
    case ValidationVerdict::inconsistent:
      return "inconsistent";
    case ValidationVerdict::inconclusive:
      return "inconclusive";
    case ValidationVerdict::not_independent:
      return "not independent";
    case ValidationVerdict::not_comparable:
      return "not comparable";
    case ValidationVerdict::not_judged:
      return "not judged";
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
    case RunGroup::Purpose::variant:
      return "variant";
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
  const ResponseExpression operand = parse_response_expression(text);
  std::vector<double> all;
  for (const JobResult* r : finished()) all.push_back(evaluate(operand, r->responses));
  return all;
}

void require_responses(const SuiteComparison& what, const JobResult& run) {
  RunGroup one;
  one.results = {run};
  const auto require = [&](const std::string& operand, const std::string& place) {
    with_place(place, [&] { one.values(operand); });
  };
  for (const Criterion& criterion : what.measurement.criteria) {
    require(criterion.lhs, criterion.lhs_place);
    require(criterion.rhs, criterion.rhs_place);
  }
  const auto& data = what.measurement.data;
  if (what.kind == ComparisonKind::curve) comparison::curves_of(one, *data);
  if (what.kind == ComparisonKind::criteria && data) comparison::response_of(run, *data);
  if (what.kind == ComparisonKind::curve || what.kind == ComparisonKind::criteria) return;
  const bool breakage = what.kind == ComparisonKind::breakage;
  for (std::size_t i = 0; i < what.responses.size(); ++i) {
    const std::string operand = (breakage ? "max " : "") + what.responses[i];
    require(operand, what.response_place(i));
    if (measures(what.kind)) comparison::require_unit(operand, one, what.measurement);
  }
}

namespace {

// Fills the part of the comparison that depends on its kind. The provenance of inputs and the
// assumptions are judged afterwards.
void compare_replicates(const SuiteComparison& what, const ComparisonRuns& e, Comparison& c) {
  switch (what.kind) {
    case ComparisonKind::value:
      comparison::compare_value(what, e, c);
      break;
    case ComparisonKind::criteria:
      comparison::compare_criteria(what, e, c);
      break;
    case ComparisonKind::breakage:
      comparison::compare_breakage(what, e, c);
      break;
    case ComparisonKind::curve:
      comparison::compare_curve(what, e, c);
      break;
    case ComparisonKind::numerical_variants:
      comparison::compare_variants(what, e, c);
      break;
    case ComparisonKind::stiffness_scaling:
      c.verdict = ValidationVerdict::not_judged;
      for (std::size_t i = 0; i < what.responses.size(); ++i)
        c.stiffness_scaling.push_back(with_place(what.response_place(i), [&] {
          return fit_stiffness_scaling(what.responses[i], e, what.real_modulus);
        }));
      c.headline = stiffness_scaling_headline(c.stiffness_scaling, what.real_modulus);
      break;
  }
}

bool decided(ValidationVerdict v) {
  return v == ValidationVerdict::consistent || v == ValidationVerdict::inconsistent;
}

// Makes a decided verdict inconclusive where too many runs are missing. Failed runs may have a
// common cause, such as a jam: then the other runs are a biased sample. Criteria already include
// their missing runs.
void judge_missing_runs(const RunGroup& base, Comparison& c) {
  if (c.kind == ComparisonKind::criteria || !decided(c.verdict)) return;
  const std::size_t with_result = c.value ? c.value->samples.size() : base.finished().size();
  const std::size_t missing = base.results.size() - with_result;
  if (!comparison::too_many_missing(missing, base.results.size())) return;
  c.verdict = ValidationVerdict::inconclusive;
  c.headline += "; but " + comparison::missing_words(base, missing);
  c.recommended_action = "why runs gave no result, or runs that give one";
}

// For each statement: whether it holds in more than half of the runs or, for one that was observed
// once, in any run.
std::vector<bool> sides(const Comparison& c) {
  std::vector<bool> all;
  for (const CriterionResult& r : c.criteria)
    all.push_back(r.criterion.observed_once_in > 0 ? r.holds > 0 : 2 * r.holds > r.runs);
  return all;
}

// The outcome of the runs, in few words.
std::string outcome_of(const Comparison& c) {
  std::string text;
  for (const CriterionResult& r : c.criteria)
    text += fmt::format("{}\"{}\" holds in {} of {} runs", text.empty() ? "" : ", ",
                        r.criterion.statement, r.holds, r.runs);
  return text.empty() ? c.headline : text;
}

// Repeats the comparison at each end of an assumed range and compares it with that of the base
// runs. The uncertainty of a value includes these differences already.
void judge_assumptions(const Suite& suite, const SuiteComparison& what, const ComparisonRuns& e,
                       Comparison& c) {
  for (const std::string& one : suite.experiments[what.experiment].assumes)
    c.caveats.push_back(fmt::format("assumed, without a range: {}", one));
  std::string changing;
  for (const ComparisonRuns::Other& other : e.variants) {
    if (!other.what->assumed || other.runs->finished().empty()) continue;
    const auto with = [&](const RunGroup* base) {
      ComparisonRuns alone;
      alone.base = alone.numerics_base = base;
      Comparison there;
      compare_replicates(what, alone, there);
      return there;
    };
    const Comparison before = with(e.numerics_base), there = with(other.runs);
    AssumptionResult r{other.what->name, static_cast<int>(other.runs->finished().size()),
                       outcome_of(there), false};
    r.changes =
        sides(before) != sides(there) ||
        (decided(before.verdict) && decided(there.verdict) && before.verdict != there.verdict);
    if (r.changes) changing += fmt::format("{}\"{}\"", changing.empty() ? "" : ", ", r.name);
    c.assumptions.push_back(r);
  }
  if (changing.empty()) return;
  c.headline += fmt::format("; depends on what is assumed: changes with {}", changing);
  if (what.kind == ComparisonKind::value || !decided(c.verdict)) return;
  c.verdict = ValidationVerdict::inconclusive;
  c.recommended_action = fmt::format("what is assumed, measured: {}", changing);
}

}  // namespace

Comparison compare(const Suite& suite, const SuiteComparison& what, const ParameterSet& parameters,
                   const ComparisonRuns& e) {
  Comparison c;
  c.name = what.name;
  c.title = what.title;
  c.note = what.note;
  c.kind = what.kind;
  c.experiment = suite.experiments[what.experiment].name;
  c.parameter_set = parameters.name;
  if (measures(what.kind)) {
    c.measurement = what.measurement.sentence();
    if (c.measurement.ends_with('.')) c.measurement.pop_back();
    c.measurement += "; " + what.measurement.source;
    c.measurement_status = status_text(what.measurement);
    c.code_to_code = what.measurement.simulated;
  }
  c.runs = static_cast<int>(e.base->results.size());
  c.finished = static_cast<int>(e.base->finished().size());
  for (const JobResult& r : e.base->results)
    if (r.status != JobStatus::finished)
      c.caveats.push_back(fmt::format("a run is {}: {}", to_string(r.status), r.reason));
  compare_replicates(what, e, c);
  judge_missing_runs(*e.base, c);
  if (measures(what.kind)) {
    judge_assumptions(suite, what, e, c);
    judge_independence(suite, what, e, c);
    if (!what.not_comparable.empty()) {
      c.verdict = ValidationVerdict::not_comparable;
      c.headline += fmt::format("; not comparable: {}", what.not_comparable);
      c.recommended_action.clear();
    }
  }
  if (c.code_to_code)
    c.caveats.emplace_back(
        "the number is another simulation's: a comparison of codes, which validates nothing");
  return c;
}

}  // namespace firn