#include "calibrate/campaign.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "experiments/version.h"

namespace firn {

std::vector<double> Point::finished(const std::string& response) const {
  std::vector<double> values;
  for (const JobResult& r : results) {
    if (r.status != JobStatus::finished) continue;
    for (const Response& candidate : r.responses)
      if (candidate.name == response && std::isfinite(candidate.value.at(0)))
        values.push_back(candidate.value[0]);
  }
  return values;
}

int Point::count(JobStatus status) const {
  return static_cast<int>(std::count_if(results.begin(), results.end(),
                                        [&](const JobResult& r) { return r.status == status; }));
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
  return {phase, number, values, to_unit(study_.parameters, values), seeds, {}, {}};
}

std::vector<Override> Campaign::overrides(const Point& point, std::uint64_t seed) const {
  std::vector<Override> all = {{"case.seed", std::to_string(seed)}};
  for (std::size_t i = 0; i < study_.parameters.size(); ++i) {
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

void Campaign::run(std::vector<Point>& points) {
  std::vector<Job> jobs;
  std::vector<PlannedRun> planned;
  std::set<std::string> wanted;
  for (Point& p : points) {
    p.keys.clear();
    for (const std::uint64_t seed : p.seeds) {
      Job job;
      job.overrides = overrides(p, seed);
      job.case_file = study_.case_file;
      job.text = executor_.resolve(job.case_file, job.overrides);
      job.key = run_key(job.text, version_);
      job.folder = folder_;
      job.threads = study_.threads;
      p.keys.push_back(job.key);
      if (!wanted.insert(job.key).second) continue;
      planned.push_back({job.key, job.text, version_, {p.phase, p.number, describe(p), seed}});
      if (const auto known = journal_.outcome(job.key)) {
        check_responses(*known);
        progress_.ended(known->wall, true, known->status == JobStatus::failed);
      } else {
        jobs.push_back(std::move(job));
      }
    }
  }
  journal_.plan(planned);
  run_jobs(std::move(jobs));
  for (Point& p : points) {
    p.results.clear();
    for (const std::string& key : p.keys) p.results.push_back(journal_.outcome(key).value());
  }
}

void Campaign::run_jobs(std::vector<Job> jobs) {
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
      check_responses(result);  // the first run tells, not the last
    };
    events.tick = [&] { progress_.tick(); };
    executor_.run(jobs, events);
    if (interrupt_ != nullptr && interrupt_->load()) throw StudyInterrupted{};
    jobs = std::move(again);
  }
}

void Campaign::check_responses(const JobResult& result) const {
  if (result.status != JobStatus::finished) return;
  const auto find = [&](const std::string& name) -> const Response& {
    std::vector<std::string> known;
    for (const Response& r : result.responses) {
      if (r.name == name && r.value.size() == 1) return r;
      if (r.value.size() == 1) known.push_back(r.name);
    }
    throw InputError(
        fmt::format("{}: response: \"{}\" is no single-valued response of {}; expected "
                    "one of {}",
                    study_.source, name, study_.case_file, fmt::join(known, ", ")));
  };
  for (const Target& t : study_.targets)
    if (const Response& r = find(t.response); r.unit != t.unit)
      throw InputError(
          fmt::format("{}: targets: \"{}\" is given in \"{}\"; expected \"{}\", the "
                      "unit of the response",
                      study_.source, t.response, t.unit, r.unit));
  for (const std::string& name : study_.observed) find(name);
}

}  // namespace firn
