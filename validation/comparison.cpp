#include "validation/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/batch/operand.h"
#include "validation/comparison_parts.h"
#include "validation/softening.h"

namespace firn {
namespace comparison {

std::string with_unit(double value, const std::string& unit) {
  return unit.empty() || unit == "1" ? fmt::format("{:.3g}", value)
                                     : fmt::format("{:.3g} {}", value, unit);
}

std::vector<double> defined(std::vector<double> values) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  return values;
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

std::string words_on(const RunGroup& group) {
  return group.purpose == RunGroup::Purpose::timestep
             ? fmt::format("time step {:.3g} us", group.setting * 1e6)
             : fmt::format("Young's modulus {:.3g} GPa", group.setting * 1e-9);
}

Change change_between(const RunGroup& base, const RunGroup& changed, const std::string& operand) {
  const Operand o = parse_operand(operand);
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
  c.before = facts_of(before).mean;
  c.after = facts_of(after).mean;
  const SampleFacts f = facts_of(difference);
  c.error = f.error();
  return c;
}

}  // namespace comparison

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
  if (measures(what.kind)) {
    c.measurement = what.measurement.sentence();
    if (c.measurement.ends_with('.')) c.measurement.pop_back();
    c.measurement += "; " + what.measurement.source;
    c.measurement_status = to_string(what.measurement.status);
  }
  c.runs = static_cast<int>(e.base->results.size());
  c.finished = static_cast<int>(e.base->finished().size());
  for (const JobResult& r : e.base->results)
    if (r.status != JobStatus::finished)
      c.caveats.push_back(fmt::format("a run is {}: {}", to_string(r.status), r.reason));
  switch (what.kind) {
    case ComparisonKind::value:
      comparison::compare_value(what, e, c);
      break;
    case ComparisonKind::claims:
      comparison::compare_claims(what, e, c);
      break;
    case ComparisonKind::damage:
      comparison::compare_damage(what, e, c);
      break;
    case ComparisonKind::curve:
      comparison::compare_curve(what, e, c);
      break;
    case ComparisonKind::choices:
      comparison::compare_choices(what, e, c);
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