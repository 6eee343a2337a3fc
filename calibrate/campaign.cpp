#include "calibrate/campaign.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "experiments/version.h"

namespace firn {
namespace {

constexpr int most_crashes = 2;  // of its own doing: then that is its outcome
constexpr int most_losses = 5;   // by no fault of its own: then something is wrong around it

}  // namespace

std::vector<double> Point::finished(const ResponseId& response) const {
  std::vector<double> values;
  if (response.experiment >= results.size()) return values;
  for (const JobResult& r : results[response.experiment])
    if (cut_short(r.status)) return {};
  for (const JobResult& r : results[response.experiment]) {
    if (r.status != JobStatus::finished) continue;
    for (const Response& candidate : r.responses)
      if (candidate.name == response.name && std::isfinite(candidate.value.at(0)))
        values.push_back(candidate.value[0]);
  }
  return values;
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
  for (const double v : values) s.mean += v / s.count;
  for (const double v : values) s.sum_of_squares += (v - s.mean) * (v - s.mean);
  return s;
}

Campaign::Campaign(const Study& study, Executor& executor, Journal& journal, RunStore* store,
                   StudyProgress& progress, std::string folder, const std::atomic<bool>* interrupt)
    : study_(study),
      executor_(executor),
      journal_(journal),
      store_(store),
      progress_(progress),
      folder_(std::move(folder)),
      program_(firn_program()),
      interrupt_(interrupt) {}

Point Campaign::point(const std::string& phase, int number, const std::vector<double>& values,
                      const std::vector<std::uint64_t>& seeds) const {
  return {phase, number, values, to_unit(study_.parameters, values), seeds, {}, {}, {}, {}};
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

std::string Campaign::describe(const Point& point) const {
  std::vector<std::string> parts;
  for (std::size_t i = 0; i < study_.parameters.size(); ++i) {
    const Parameter& p = study_.parameters[i];
    parts.push_back(
        fmt::format("{}={}{}{}", p.name, point.values[i], p.unit.empty() ? "" : " ", p.unit));
  }
  return fmt::format("{}", fmt::join(parts, " "));
}

Job Campaign::job(const Point& point, const Experiment& experiment, std::uint64_t seed) const {
  Job job;
  job.overrides = overrides_of(study_, experiment, point.values, seed, point.set);
  job.case_file = experiment.case_file;
  job.text = executor_.resolve(job.case_file, job.overrides);
  job.key = run_key(job.text, program_);
  job.folder = folder_;
  job.threads = study_.threads;
  job.limits = study_.execution.limits;
  return job;
}

void Campaign::run(std::vector<Point>& points) {
  std::vector<Job> jobs;
  std::vector<PlannedRun> planned;
  WantedRuns wanted;
  for (Point& p : points) {
    p.keys.assign(study_.experiments.size(), {});
    for (std::size_t e = 0; e < study_.experiments.size(); ++e) {
      if (p.only && *p.only != e) continue;
      for (const std::uint64_t seed : p.seeds) {
        Job next = job(p, study_.experiments[e], seed);
        p.keys[e].push_back(next.key);
        asked_.insert(next.key);
        const PlannedRun run{next.key,
                             next.text,
                             program_,
                             {study_.experiments[e].name, p.phase, p.number, describe(p), seed}};
        if (!wanted.emplace(next.key, Wanted{run, e}).second) continue;
        planned.push_back(run);
        jobs.push_back(std::move(next));
      }
    }
  }
  journal_.plan(planned);
  std::erase_if(jobs, [&](const Job& job) {
    const Wanted& w = wanted.at(job.key);
    const auto known = known_outcome(w.run);
    if (!known) return false;
    check_responses(w.experiment, *known);
    progress_.found(w.run, *known);
    return true;
  });
  run_jobs(std::move(jobs), wanted);
  for (Point& p : points) {
    p.results.assign(p.keys.size(), {});
    for (std::size_t e = 0; e < p.keys.size(); ++e)
      for (const std::string& key : p.keys[e])
        p.results[e].push_back(journal_.outcome(key).value());
  }
}

// In the journal, or else in the store that studies share; what is found there goes to the journal,
// so that a study stays whole without the store. A run that was cut short is known only as long as
// it may take no more than it took.
std::optional<JobResult> Campaign::known_outcome(const PlannedRun& run) {
  const RunLimits& limits = study_.execution.limits;
  const auto stands = [&](const std::optional<JobResult>& r) {
    if (!r) return false;
    const double now = r->status == JobStatus::timed_out ? limits.time : limits.memory;
    return !cut_short(r->status) || (now > 0 && now <= r->limit);
  };
  auto known = journal_.outcome(run.key);
  if (stands(known)) return known;
  if (store_ == nullptr || !stands(known = store_->find(run.key))) return std::nullopt;
  journal_.finish(run.key, *known);
  return known;
}

void Campaign::run_jobs(std::vector<Job> jobs, const WantedRuns& wanted) {
  std::map<std::string, int> crashes, losses;
  std::map<std::string, double> reached;  // s simulated
  while (!jobs.empty()) {
    std::vector<Job> again;
    JobEvents events;
    events.started = [&](const Job& job) {
      journal_.start(job.key);
      progress_.started(wanted.at(job.key).run);
    };
    events.ended = [&](const Job& job, const JobResult& result) {
      const auto& [run, experiment] = wanted.at(job.key);
      const bool lost = result.status == JobStatus::lost;
      // One that gets on between losses will get there.
      if (lost && result.simulated > reached[job.key]) losses[job.key] = 0;
      if (lost) reached[job.key] = result.simulated;
      if (lost && ++losses[job.key] == most_losses)
        throw RunError(fmt::format(
            "run {}: {}, {} times in a row; everything finished is kept, and the same command goes "
            "on from there",
            job.key, result.reason, most_losses));
      // A process that died may have done so for reasons that are not its own.
      if (lost || (result.status == JobStatus::crashed && ++crashes[job.key] < most_crashes)) {
        again.push_back(job);
        return progress_.stopped(run, result);
      }
      if (result.status == JobStatus::interrupted) return progress_.stopped(run, result);
      journal_.finish(job.key, result);
      if (store_ != nullptr) store_->add(run, result);
      progress_.ended(run, result);
      check_responses(experiment, result);  // the first run tells, not the last
    };
    events.tick = [&] { progress_.tick(); };
    executor_.run(jobs, events);
    if (interrupt_ != nullptr && interrupt_->load()) throw StudyInterrupted{};
    jobs = std::move(again);
  }
}

void Campaign::check_responses(std::size_t experiment, const JobResult& result) const {
  if (result.status != JobStatus::finished) return;
  const auto check = [&](const char* what, const ResponseId& id, const std::string& unit) {
    if (id.experiment != experiment) return;
    std::vector<std::string> known;
    for (const Response& r : result.responses) {
      if (r.value.size() != 1) continue;
      known.push_back(r.name);
      if (r.name != id.name) continue;
      if (!unit.empty() && r.unit != unit)
        throw InputError(
            fmt::format("{}: {}: \"{}\" is given in \"{}\"; expected \"{}\", the "
                        "unit of the response",
                        study_.source, what, id.label, unit, r.unit));
      return;
    }
    throw InputError(fmt::format(
        "{}: response: \"{}\" is no single-valued response of {}; expected "
        "one of {}",
        study_.source, id.name, study_.experiments[experiment].case_file, fmt::join(known, ", ")));
  };
  for (const Target& t : study_.targets) check("targets", t.response, t.unit);
  for (const Observed& o : study_.observed) check("observe", o.response, o.unit);
}

}  // namespace firn
