#include "calibrate/study/study_runs.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <string_view>

#include "experiments/analysis/sample_statistics.h"
#include "experiments/batch/override_places.h"
#include "experiments/text/units.h"

namespace firn {

std::vector<double> Point::finished(const ResponseId& response) const {
  std::vector<double> values;
  if (response.experiment >= results.size()) return values;
  for (const JobResult& r : results[response.experiment])
    if (cut_short(r.status)) return {};
  const auto left_out = outliers.find(response.label);
  for (std::size_t s = 0; s < results[response.experiment].size(); ++s) {
    if (left_out != outliers.end() && left_out->second.contains(s)) continue;
    if (const auto y = value(response, s)) values.push_back(*y);
  }
  return values;
}

std::optional<double> Point::value(const ResponseId& response, std::size_t seed) const {
  const JobResult& r = results[response.experiment][seed];
  if (r.status != JobStatus::finished) return std::nullopt;
  for (const Response& candidate : r.responses)
    if (candidate.name == response.name && candidate.value.size() == 1 &&
        std::isfinite(candidate.value[0]))
      return candidate.value[0];
  return std::nullopt;
}

std::string Point::unit(const ResponseId& response) const {
  if (response.experiment < results.size())
    for (const JobResult& result : results[response.experiment])
      for (const Response& r : result.responses)
        if (r.name == response.name) return r.unit;
  return {};
}

int Point::count(JobStatus status, std::size_t experiment) const {
  if (experiment >= results.size()) return 0;
  return static_cast<int>(std::count_if(results[experiment].begin(), results[experiment].end(),
                                        [&](const JobResult& r) { return r.status == status; }));
}

int Point::count(JobStatus status) const {
  int sum = 0;
  for (std::size_t e = 0; e < results.size(); ++e) sum += count(status, e);
  return sum;
}

double Point::wall() const {
  double sum = 0;
  for (const auto& runs : results)
    for (const JobResult& r : runs) sum += r.wall;
  return sum;
}

double Sample::sd() const {
  return count < 2 ? std::numeric_limits<double>::quiet_NaN()
                   : std::sqrt(sum_of_squares / (count - 1));
}

Sample sample(const std::vector<double>& values) {
  Sample s;
  s.count = static_cast<int>(values.size());
  if (values.empty()) return s;
  s.mean = mean(values);
  s.sum_of_squares = sum_of_squares(values, s.mean);
  return s;
}

StudyRuns::StudyRuns(const Study& study, Executor& executor, Journal& journal, RunCache* store,
                     BatchProgress& progress, std::string folder,
                     const std::atomic<bool>* interrupt)
    : study_(study),
      journal_(journal),
      store_(store),
      batch_(executor, journal, store, progress, interrupt),
      program_(batch_.program()),
      folder_(std::move(folder)) {
  const auto& experiments = study.experiments;
  if (std::all_of(experiments.begin(), experiments.end(),
                  [](const Experiment& e) { return e.program.has_value(); }))
    program_ = user_program_identity;
  for (const Experiment& e : experiments)
    if (e.program) keep_inputs(*e.program, folder_);
}

Point StudyRuns::point(const std::string& phase, int number, const std::vector<double>& values,
                       const std::vector<std::uint64_t>& seeds) const {
  return {phase, number, values, to_unit(study_.parameters, values), seeds, {}, {}, {}, {}};
}

Point StudyRuns::in_low_fidelity(Point point) const {
  point.phase = low_fidelity_phase + point.phase;
  for (std::size_t e = 0; e < study_.experiments.size(); ++e)
    point.low_fidelity.push_back(study_.low_fidelity->applies(e));
  return point;
}

std::vector<Override> overrides_of(const Study& study, const Experiment& experiment,
                                   const std::vector<double>& values, std::uint64_t seed,
                                   const std::vector<Override>& of_the_point) {
  std::vector<Override> all = {{"case.seed", std::to_string(seed)}};
  all.insert(all.end(), experiment.set.begin(), experiment.set.end());
  all.insert(all.end(), of_the_point.begin(), of_the_point.end());
  for (std::size_t i = 0; i < study.parameters.size(); ++i) {
    if (!experiment.takes[i]) continue;
    const Parameter& p = study.parameters[i];
    const std::string value =
        p.unit.empty() ? fmt::format("{}", values[i]) : fmt::format("\"{} {}\"", values[i], p.unit);
    for (const std::string& key : p.keys) all.emplace_back(key, value);
  }
  return all;
}

std::map<std::string, std::string> placeholders_of(const Study& study, const Experiment& experiment,
                                                   const std::vector<double>& values,
                                                   std::uint64_t seed,
                                                   const std::vector<Override>& of_the_point) {
  std::map<std::string, std::string> texts = {{"seed", std::to_string(seed)}};
  for (const auto* overrides : {&experiment.set, &of_the_point})
    for (const auto& [key, value] : *overrides) texts[key] = placeholder_text(value);
  for (std::size_t i = 0; i < study.parameters.size(); ++i)
    if (experiment.takes[i]) texts[study.parameters[i].name] = fmt::format("{}", values[i]);
  return texts;
}

namespace {

MaterialRequest material_of(const Study& study, std::uint64_t seed) {
  if (study.drawn_material.empty()) return {};
  return {{fmt::format("{}#{}", study.drawn_material, seed)}, ""};
}

}  // namespace

std::string StudyRuns::describe(const Point& point) const {
  std::vector<std::string> parts;
  for (std::size_t i = 0; i < study_.parameters.size(); ++i) {
    const Parameter& p = study_.parameters[i];
    parts.push_back(
        fmt::format("{}={}{}{}", p.name, point.values[i], p.unit.empty() ? "" : " ", p.unit));
  }
  if (const std::string chosen = study_.chosen_text(); !chosen.empty()) parts.push_back(chosen);
  return fmt::format("{}", fmt::join(parts, " "));
}

// The opposite of describe(); nothing for other parameters than the study's.
std::optional<std::vector<double>> StudyRuns::values_of(const std::string& text) const {
  std::vector<double> values;
  std::size_t at = 0;
  const auto take = [&](const std::string& word) {
    if (text.compare(at, word.size(), word) != 0) return false;
    at += word.size();
    return true;
  };
  for (const Parameter& p : study_.parameters) {
    if (!values.empty() && !take(" ")) return std::nullopt;
    if (!take(p.name + "=")) return std::nullopt;
    double value = 0;
    const char* end = text.data() + text.size();
    const auto [rest, error] = std::from_chars(text.data() + at, end, value);
    if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
    at = static_cast<std::size_t>(rest - text.data());
    if (!p.unit.empty() && !take(" " + p.unit)) return std::nullopt;
    values.push_back(value);
  }
  if (const std::string chosen = study_.chosen_text(); !chosen.empty() && !take(" " + chosen))
    return std::nullopt;
  if (at != text.size()) return std::nullopt;
  return values;
}

std::vector<Point> StudyRuns::reusable(int most_runs) {
  std::vector<Point> points;
  const auto add = [&](const std::vector<double>& values, std::uint64_t seed) {
    for (Point& p : points)
      if (p.values == values) {
        if (std::find(p.seeds.begin(), p.seeds.end(), seed) == p.seeds.end())
          p.seeds.push_back(seed);
        return;
      }
    points.push_back(point(reused_phase, static_cast<int>(points.size()), values, {seed}));
  };
  const std::vector<JournalRun> before = journal_.runs();
  for (const JournalRun& run : before)
    if (run.label.phase == reused_phase && run.program == program())
      if (const auto values = values_of(run.label.parameters)) add(*values, run.label.seed);
  if (!before.empty() || store_ == nullptr) return points;
  int runs = 0;
  const int each = static_cast<int>(study_.experiments.size());
  for (const RunCache::Known& known : store_->of_other_studies(program())) {
    if (runs + each > most_runs) break;
    const auto values = values_of(known.parameters);
    if (!values) continue;
    bool ended = true;
    for (std::size_t i = 0; i < values->size(); ++i)
      ended = ended && (*values)[i] >= study_.parameters[i].min &&
              (*values)[i] <= study_.parameters[i].max;
    const Point one = point(reused_phase, 0, *values, {known.seed});
    for (std::size_t e = 0; ended && e < study_.experiments.size(); ++e) {
      const auto outcome = store_->find(batch_run(one, e, known.seed).job.key);
      ended = outcome && !cut_short(outcome->status);
    }
    if (!ended) continue;
    add(*values, known.seed);
    runs += each;
  }
  return points;
}

namespace {

// Where the study states a value that it sets in the case of an experiment; empty: nowhere.
OverridePlace place_of(const Study& study, const Experiment& experiment, const Override& o) {
  const auto among = [](const std::vector<std::string>& texts, const std::string& text,
                        const std::vector<ValuePlace>& places) -> const ValuePlace* {
    const auto found = std::find(texts.begin(), texts.end(), text);
    if (found == texts.end() || places.empty()) return nullptr;
    return &places.at(static_cast<std::size_t>(found - texts.begin()));
  };
  for (std::size_t i = 0; i < study.parameters.size(); ++i) {
    const Parameter& p = study.parameters[i];
    if (!experiment.takes[i]) continue;
    if (const ValuePlace* key = among(p.keys, o.first, p.key_places)) return {*key, *key};
  }
  if (const auto& c = study.choice)
    if (const ValuePlace* key = among(c->keys, o.first, c->key_places)) {
      const ValuePlace* value = among(c->values, o.second, c->value_places);
      return {*key, value != nullptr ? *value : *key};
    }
  const auto sets = [&](const std::vector<Override>& set) {
    return std::find(set.begin(), set.end(), o) != set.end();
  };
  if (const auto& low = study.low_fidelity; low && sets(low->set))
    return place_among(low->set, low->set_places, o);
  for (const NumericsCheck& check : study.numerics)
    if (sets(check.set)) return place_among(check.set, check.set_places, o);
  return place_among(experiment.set, experiment.set_places, o);
}

}  // namespace

BatchRun StudyRuns::case_run(const Experiment& experiment, const Point& point, std::uint64_t seed,
                             const std::vector<Override>& set, const RunLabel& label) const {
  const std::vector<Override> overrides = overrides_of(study_, experiment, point.values, seed, set);
  return with_override_places(
      experiment.case_file, overrides,
      [&](const Override& o) { return place_of(study_, experiment, o); },
      [&] {
        return batch_.make(experiment.case_file, overrides, folder_, label,
                           material_of(study_, seed));
      });
}

BatchRun StudyRuns::batch_run(const Point& point, std::size_t e, std::uint64_t seed) const {
  const Experiment& experiment = study_.experiments[e];
  const RunLabel label{experiment.name, point.phase, point.number, describe(point), seed};
  std::vector<Override> set = point.set;
  if (point.is_low_fidelity(e))
    set.insert(set.end(), study_.low_fidelity->set.begin(), study_.low_fidelity->set.end());
  BatchRun run =
      experiment.program
          ? batch_.make(program_run(*experiment.program,
                                    placeholders_of(study_, experiment, point.values, seed, set)),
                        folder_, label)
          : case_run(experiment, point, seed, set, label);
  run.job.threads = study_.threads;
  run.job.limits = study_.execution.limits;
  return run;
}

void StudyRuns::run(std::vector<Point>& points) {
  std::vector<BatchRun> runs;
  std::map<std::string, std::size_t> experiments;  // by key
  for (Point& p : points) {
    p.keys.assign(study_.experiments.size(), {});
    for (std::size_t e = 0; e < study_.experiments.size(); ++e) {
      if (p.only && *p.only != e) continue;
      for (const std::uint64_t seed : p.seeds) {
        runs.push_back(batch_run(p, e, seed));
        p.keys[e].push_back(runs.back().job.key);
        requested_.insert(runs.back().job.key);
        experiments.emplace(runs.back().job.key, e);
      }
    }
  }
  batch_.run(runs, [&](const BatchRun& run, const JobResult& result) {
    check_responses(experiments.at(run.job.key), result);
  });
  for (Point& p : points) {
    p.results.assign(p.keys.size(), {});
    for (std::size_t e = 0; e < p.keys.size(); ++e)
      for (const std::string& key : p.keys[e]) p.results[e].push_back(batch_.outcome(key));
  }
}

void StudyRuns::check_responses(std::size_t experiment, const JobResult& result) const {
  if (result.status != JobStatus::finished) return;
  const auto check = [&](const char* what, const ResponseId& id, const std::string& unit) {
    if (id.experiment != experiment) return;
    std::vector<std::string> known;
    for (const Response& r : result.responses) {
      if (r.value.size() != 1) continue;
      known.push_back(r.name);
      if (r.name != id.name) continue;
      if (!unit.empty() && plain_unit(r.unit) != unit)
        throw InputError(
            fmt::format("{}: {}: \"{}\" is given in \"{}\"; expected \"{}\", the "
                        "unit of the response",
                        study_.source, what, id.label, unit, r.unit));
      return;
    }
    throw InputError(fmt::format(
        "{}: response: \"{}\" is not a single-valued response of {}; expected "
        "one of {}",
        study_.source, id.name, study_.experiments[experiment].source(), fmt::join(known, ", ")));
  };
  for (const Target& t : study_.targets) check("targets", t.response, t.unit);
  for (const CurveTarget& c : study_.curves) {
    if (c.experiment != experiment) continue;
    try {
      simulated_curve(c, result);
    } catch (const InputError& e) {
      throw InputError(fmt::format("{}: targets: {}: {}", study_.source, c.label, e.what()));
    }
  }
  for (const Observed& o : study_.observed) check("observe", o.response, o.unit);
}

}  // namespace firn
