#include "reports/documents/study_estimate.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "calibrate/output/study_verdict.h"
#include "experiments/text/number_text.h"

namespace firn {
namespace {

std::string joined(const std::vector<std::string>& parts, const char* none) {
  return parts.empty() ? none : fmt::format("{}", fmt::join(parts, "; "));
}

// "law = linear (probability 0.97)"
std::string chosen(const StudyDocument::Choices& choice) {
  for (const StudyDocument::Choices::Choice& c : choice.choices)
    if (c.label == choice.best)
      return fmt::format("{} = {} (probability {})", choice.parameter, choice.best,
                         number_text(c.probability, 2));
  return fmt::format("{} = {}", choice.parameter, choice.best);
}

// What a verdict adds to the estimate.
struct VerdictWords {
  StudyVerdict verdict = StudyVerdict::calibrated;
  // Why the values are no recommendation, and what they are; empty: they are one.
  const char* reservation = "";
  const char* addition = "";  // behind the values that are recommended
  const char* basis = "";     // before the combinations, where the study contradicts their basis
};

VerdictWords words_of(const StudyDocument& results) {
  static constexpr VerdictWords kAll[] = {
      {StudyVerdict::infeasible,
       "nothing, since no values within the ranges meet all targets; nearest: ", "",
       "by a fit that misses the targets: "},
      {StudyVerdict::prior_conflict,
       "nothing, since the priors conflict with the targets; nearest to both: ", "",
       "by priors and targets that conflict: "},
      {StudyVerdict::unconfirmed,
       "nothing, since fresh runs did not confirm the fitted values; fitted: ", "",
       "by a fit that is not confirmed: "},
      {StudyVerdict::not_identifiable, "", "; other values meet the targets as well", ""},
      {StudyVerdict::direct_search_only, "",
       "; the best of a direct search, of unknown uncertainty", ""}};
  for (const VerdictWords& words : kAll)
    if (results.verdict == to_string(words.verdict)) return words;
  return {};
}

// "ice_ice = 0.24 (95 %: 0.17 to 0.3)". Where nothing is recommended, the interval would hold the
// truth of a model that is refuted: the values alone.
std::string recommended(const StudyDocument& results) {
  const VerdictWords words = words_of(results);
  const std::string reserved = words.reservation;
  std::vector<std::string> parts;
  if (results.choice) parts.push_back(chosen(*results.choice));
  for (const StudyDocument::Parameter& p : results.parameters) {
    const double* value = find_named(results.estimate->parameters, p.name);
    if (value == nullptr) continue;
    std::string text = fmt::format("{} = {}{}", p.name, number_text(*value), unit_suffix(p.unit));
    if (p.interval_95 && reserved.empty())
      text += fmt::format(" (95 %: {} to {})", number_text(p.interval_95->first, 3),
                          number_text(p.interval_95->second, 3));
    parts.push_back(text);
  }
  return reserved + joined(parts, "no values") + words.addition;
}

std::string determined(const StudyDocument& results) {
  std::vector<std::string> known, unknown;
  for (const StudyDocument::Combination& c : results.combinations) {
    if (c.identifiable)
      known.push_back(
          fmt::format("{} = {}", combination_text(c), measured_text(c.value, c.uncertainty)));
    else
      unknown.push_back(combination_text(c));
  }
  // A direct search has no model, from which they follow.
  if (known.empty() && unknown.empty()) return "not examined";
  return fmt::format("{}{}. Not determined: {}", words_of(results).basis, joined(known, "nothing"),
                     joined(unknown, "nothing that was varied"));
}

// The simulated responses of the targets.
std::string simulated(const StudyDocument::Set& set, const StudyDocument& results) {
  std::vector<std::string> parts;
  for (const auto& [response, of] : set.simulated)
    if (std::ranges::find(results.targets, response, &StudyDocument::Target::response) !=
        results.targets.end())
      parts.push_back(response + " " + measured_text(of.value, of.standard_error, of.unit));
  return joined(parts, "no finished run");
}

std::string compared(const StudyDocument& results) {
  std::vector<std::string> parts;
  for (const StudyDocument::Set& set : results.compare)
    parts.push_back(fmt::format("{}: {}", set.name, simulated(set, results)));
  return joined(parts, "the study has no [[compare]] values");
}

// Share of the variance of the combination known best that the runs make: their scatter and what
// lies between them. The measurements and discrepancies make the rest. 0: nothing is determined.
double share_of_runs(const StudyDocument& results) {
  for (const StudyDocument::Combination& c : results.combinations) {
    if (!c.identifiable || !c.split) continue;
    const auto square = [](double sd) { return sd * sd; };
    const double runs = square(c.split->seed_noise) + square(c.split->surrogate);
    const double all =
        runs + square(c.split->measurement) + square(c.split->discrepancy.value_or(0));
    return all > 0 ? runs / all : 0;
  }
  return 0;
}

std::string next(const StudyDocument& results) {
  const double runs = share_of_runs(results);
  const std::string first =
      runs > 0.5 ? fmt::format(
                       "first more runs (a larger budget): they make {:.0f} % of the variance "
                       "of what is determined; then ",
                       100 * runs)
                 : "";
  if (results.measure_next.empty()) return first + "nothing is known to help";
  const StudyDocument::Advice& best = results.measure_next.front();
  std::string text = first + best.response;
  if (best.repeats_a_target) text += ", once more";
  text += fmt::format(": {} bits", number_text(best.information_bits, 2));
  if (!std::isnan(best.remaining_extent))
    text += fmt::format("; the least known direction shrinks to {:.0f} % of its length",
                        100 * best.remaining_extent);
  return text;
}

}  // namespace

std::string combination_text(const StudyDocument::Combination& combination) {
  std::string text;
  for (const StudyDocument::Combination::Term& term : combination.terms) {
    const double factor = term.coefficient;
    const std::string what =
        term.of == "logarithm" ? fmt::format("ln({})", term.parameter) : term.parameter;
    text += text.empty()
                ? fmt::format("{:.2f} {}", factor, what)
                : fmt::format(" {} {:.2f} {}", factor < 0 ? "-" : "+", std::abs(factor), what);
  }
  return text;
}

std::vector<page::Property> study_estimate(const StudyDocument& results) {
  if (!results.estimate) return {};
  return {{"Recommended", recommended(results)},
          {"Determined", determined(results)},
          {"Compared", compared(results)},
          {"Measure next", next(results)}};
}

}  // namespace firn
