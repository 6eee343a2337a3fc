#include "calibrate/campaign.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "experiments/version.h"

namespace firn {

std::vector<double> Point::finished(const ResponseId& response) const {
  std::vector<double> values;
  if (response.experiment >= results.size()) return values;
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

Campaign::Campaign(const Study& study, Executor& executor, Journal& journal,
                   StudyProgress& progress, std::string folder, const std::atomic<bool>* interrupt)
    : study_(study),
      executor_(executor),
      journal_(journal),
      progress_(progress),
      folder_(std::move(folder)),
      version_(fmt::format("{} {}", firn_version(), firn_git_commit())),
      interrupt_(interrupt) {}

Point Campaign::point(const std::string& phase, int number, const std::vector<double>& values,
                      const std::vector<std::uint64_t>& seeds) const {
  return {phase, number, values, to_unit(study_.parameters, values), seeds, {}, {}, {}};
}

std::vector<Override> Campaign::overrides(const Point& point, const Experiment& experiment,
                                          std::uint64_t seed) const {
  std::vector<Override> all = {{"case.seed", std::to_string(seed)}};
  all.insert(all.end(), experiment.set.begin(), experiment.set.end());
  all.insert(all.end(), point.set.begin(), point.set.end());
  for (std::size_t i = 0; i < study_.parameters.size(); ++i) {
    if (!experiment.takes[i]) continue;
    const Parameter& p = study_.parameters[i];
    const std::string value = p.unit.empty() ? fmt::format("{}", point.values[i])
                                             : fmt::format("\"{} {}\"", point.values[i], p.unit);
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
  job.overrides = overrides(point, experiment, seed);
  job.case_file = experiment.case_file;
  job.text = executor_.resolve(job.case_file, job.overrides);
  job.key = run_key(job.text, version_);
  job.folder = folder_;
  job.threads = study_.threads;
  return job;
}

void Campaign::run(std::vector<Point>& points) {
  std::vector<Job> jobs;
  std::vector<PlannedRun> planned;
  std::map<std::string, std::size_t> wanted;  // run -> its experiment
  for (Point& p : points) {
    p.keys.assign(study_.experiments.size(), {});
    for (std::size_t e = 0; e < study_.experiments.size(); ++e)
      for (const std::uint64_t seed : p.seeds) {
        Job next = job(p, study_.experiments[e], seed);
        p.keys[e].push_back(next.key);
        if (!wanted.emplace(next.key, e).second) continue;
        planned.push_back({next.key,
                           next.text,
                           version_,
                           {study_.experiments[e].name, p.phase, p.number, describe(p), seed}});
        if (const auto known = journal_.outcome(next.key)) {
          check_responses(e, *known);
          progress_.ended(known->wall, true, known->status == JobStatus::failed);
        } else {
          jobs.push_back(std::move(next));
        }
      }
  }
  journal_.plan(planned);
  run_jobs(std::move(jobs), wanted);
  for (Point& p : points) {
    p.results.assign(p.keys.size(), {});
    for (std::size_t e = 0; e < p.keys.size(); ++e)
      for (const std::string& key : p.keys[e])
        p.results[e].push_back(journal_.outcome(key).value());
  }
}

void Campaign::run_jobs(std::vector<Job> jobs,
                        const std::map<std::string, std::size_t>& experiments) {
  std::map<std::string, int> crashes;
  while (!jobs.empty()) {
    std::vector<Job> again;
    JobEvents events;
    events.started = [&](const Job& job) {
      journal_.start(job.key);
      progress_.started();
    };
    events.ended = [&](const Job& job, const JobResult& result) {
      if (result.status == JobStatus::interrupted) return progress_.stopped();
      // A process that died may have been killed for reasons that are not its own.
      if (result.status == JobStatus::crashed && ++crashes[job.key] < 2) {
        again.push_back(job);
        return progress_.stopped();
      }
      journal_.finish(job.key, result);
      progress_.ended(result.wall, false, result.status == JobStatus::failed);
      check_responses(experiments.at(job.key), result);  // the first run tells, not the last
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
