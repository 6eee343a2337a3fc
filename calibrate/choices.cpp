#include "calibrate/choices.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "calibrate/calibration.h"

namespace firn {
namespace {

constexpr double determined = 0.95;  // probability from which a choice counts as known

// Fills in the probabilities: prior times evidence, shared among those that have a posterior.
void judge_choices(const std::vector<CalibrationResult>& results,
                   std::vector<ChoiceOutcome>& choices) {
  double most = 0, sum = 0;
  bool any = false;
  for (const CalibrationResult& r : results)
    if (r.posterior) {
      most = any ? std::max(most, r.posterior->log_evidence) : r.posterior->log_evidence;
      any = true;
    }
  for (std::size_t i = 0; i < results.size(); ++i)
    if (const auto& posterior = results[i].posterior) {
      choices[i].probability = choices[i].prior * std::exp(posterior->log_evidence - most);
      sum += *choices[i].probability;
    }
  for (ChoiceOutcome& c : choices)
    if (c.probability) *c.probability /= sum;
}

// The most probable of those that meet the targets; of all where none does.
std::size_t best_of(const std::vector<ChoiceOutcome>& choices) {
  const auto rank = [](const ChoiceOutcome& c) {
    return std::pair(c.goodness && c.goodness->acceptable(), c.probability.value_or(-1));
  };
  const auto best = std::max_element(
      choices.begin(), choices.end(),
      [&](const ChoiceOutcome& a, const ChoiceOutcome& b) { return rank(a) < rank(b); });
  return static_cast<std::size_t>(best - choices.begin());
}

// The verdict and headline of the whole study, from those of its best choice.
void conclude_choices(const ChoiceParameter& parameter, CalibrationResult& a) {
  const ChoiceOutcome& best = a.choices[a.best_choice];
  std::vector<std::string> shares, unknown;
  for (const ChoiceOutcome& c : a.choices) {
    if (c.probability)
      shares.push_back(fmt::format("{} {:.2g}", c.label, *c.probability));
    else
      unknown.push_back(c.label);
  }
  if (!unknown.empty()) {
    a.caveats.push_back(
        fmt::format("too few runs finished for {} = {}", parameter.name, fmt::join(unknown, ", ")));
    a.headline += "; " + a.caveats.back();
  }
  const bool answered =
      a.verdict == StudyVerdict::calibrated || a.verdict == StudyVerdict::not_identifiable;
  if (answered && best.probability.value_or(0) < determined) {
    a.verdict = StudyVerdict::not_identifiable;
    a.headline = fmt::format("the targets do not determine {} (probabilities: {}); with {}: {}",
                             parameter.name, fmt::join(shares, ", "), best.label, a.headline);
    return;
  }
  a.headline = fmt::format(
      "{} = {}{}: {}", parameter.name, best.label,
      best.probability ? fmt::format(" (probability {:.2g})", *best.probability) : "", a.headline);
}

}  // namespace

std::vector<Study> parts_of(const Study& study) {
  if (!study.choice) return {study};
  const ChoiceParameter& choice = *study.choice;
  std::vector<Study> parts;
  for (std::size_t i = 0; i < choice.values.size(); ++i) {
    Study part = study;
    part.chosen = i;
    part.budget.time /= static_cast<double>(choice.values.size());
    // Which runs another study had made is decided once for a folder, not for each choice.
    part.budget.reuse = false;
    for (Experiment& e : part.experiments) {
      if (!e.takes_choice) continue;
      if (e.program) e.set.emplace_back(choice.name, choice.values[i]);
      if (!e.program)
        for (const std::string& key : choice.keys) e.set.emplace_back(key, choice.values[i]);
    }
    parts.push_back(std::move(part));
  }
  return parts;
}

CalibrationResult calibrate_choices(const std::vector<Study>& parts, const PartRuns& runs,
                                    BatchProgress& progress) {
  std::vector<Calibration> calibrations;
  for (std::size_t i = 0; i < parts.size(); ++i)
    calibrations.emplace_back(parts[i], *runs[i], progress);
  for (Calibration& c : calibrations) c.make_runs();
  std::vector<std::vector<Point>> elsewhere(parts.size());
  for (std::size_t i = 0; i < parts.size(); ++i)
    for (std::size_t j = 0; j < parts.size(); ++j)
      if (j != i)
        elsewhere[i].insert(elsewhere[i].end(), calibrations[j].points().begin(),
                            calibrations[j].points().end());
  const ChoiceParameter& choice = *parts.front().choice;
  std::vector<CalibrationResult> results;
  std::vector<ChoiceOutcome> choices;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    results.push_back(calibrations[i].conclude(elsewhere[i]));
    const CalibrationResult& r = results.back();
    ChoiceOutcome c;
    c.label = choice.labels[i];
    c.prior = choice.prior[i];
    c.verdict = r.verdict;
    c.headline = r.headline;
    c.best = r.best.values;
    if (r.posterior) c.marginals = r.posterior->marginals;
    c.goodness = r.goodness;
    choices.push_back(std::move(c));
  }
  judge_choices(results, choices);
  const std::size_t best = best_of(choices);
  CalibrationResult a = std::move(results[best]);
  for (std::size_t i = 0; i < results.size(); ++i) {
    if (i == best) continue;
    a.budget_runs += results[i].budget_runs;
    a.budget_left += results[i].budget_left;
    if (a.left_because.empty()) a.left_because = results[i].left_because;
  }
  a.choices = std::move(choices);
  a.best_choice = best;
  conclude_choices(choice, a);
  return a;
}

}  // namespace firn
