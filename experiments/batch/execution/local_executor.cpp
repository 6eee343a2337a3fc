#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <filesystem>
#include <thread>

#include "experiments/batch/execution/executor.h"
#include "experiments/batch/execution/run_process.h"
#include "experiments/batch/execution/running_job.h"
#include "experiments/case_reader/read_case.h"
#include "experiments/text/units.h"

namespace firn {
namespace {

class LocalExecutor final : public Executor {
 public:
  explicit LocalExecutor(const LocalExecutorOptions& options) : options_(options) {
    if (options_.program.empty()) options_.program = current_executable();
    if (options_.jobs <= 0)
      options_.jobs = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  }

  void run(const std::vector<Job>& jobs, const JobEvents& events) override {
    std::deque<Job> waiting(jobs.begin(), jobs.end());
    Running running;
    bool stop_requested = false;
    while (!waiting.empty() || !running.empty()) {
      const bool stop = options_.interrupt != nullptr && options_.interrupt->load();
      if (stop) waiting.clear();
      if (stop && !stop_requested)
        for (const auto& run : running) run->interrupt();
      stop_requested = stop;
      while (!waiting.empty() && static_cast<int>(running.size()) < options_.jobs) {
        const Job job = waiting.front();
        waiting.pop_front();
        events.started(job);
        if (const auto known = existing_result(job))  // ended unseen: nothing to repeat
          events.ended(job, *known);
        else
          running.push_back(start_job(job, options_.program, [&, job](const std::string& line) {
            if (events.note) events.note(job, line);
          }));
      }
      std::erase_if(running, [&](const auto& run) {
        const auto result = run->poll();
        if (result) events.ended(run->job(), *result);
        return result.has_value();
      });
      if (events.tick) events.tick();
      if (!running.empty()) std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
  }

 private:
  struct Running : std::vector<std::unique_ptr<RunningJob>> {
    // On an exception while runs are active, they save their state and end.
    ~Running() {
      for (const auto& run : *this) run->interrupt();
    }
  };

  LocalExecutorOptions options_;
};

}  // namespace

ResolvedCase Executor::resolve(const std::string& case_file, const std::vector<Override>& overrides,
                               const MaterialRequest& materials) {
  Case c = read_case(case_file, overrides, materials);
  return {std::move(c.resolved), std::move(c.identity)};
}

std::string current_executable() {
  return std::filesystem::read_symlink("/proc/self/exe").string();
}

const char* to_string(JobStatus status) {
  switch (status) {
    case JobStatus::finished:
      return "finished";
    case JobStatus::arched:
      return "arched";
    case JobStatus::failed:
      return "failed";
    case JobStatus::crashed:
      return "crashed";
    case JobStatus::timed_out:
      return "timed out";
    case JobStatus::out_of_memory:
      return "out of memory";
    case JobStatus::lost:
      return "lost";
    case JobStatus::interrupted:
      return "interrupted";
  }
  return "";
}

std::optional<JobStatus> outcome_status(const std::string& text) {
  for (const JobStatus status : outcomes)
    if (text == to_string(status)) return status;
  return std::nullopt;
}

bool holds_within(const RunLimits& limits, const JobResult& result) {
  if (!cut_short(result.status)) return true;
  const double limit = result.status == JobStatus::timed_out ? limits.time : limits.memory;
  return limit > 0 && limit <= result.limit;
}

JobResult plausible(JobResult result) {
  constexpr double kLargest = 1e30, kLongest = 1e12;  // s
  const auto refuse = [&](const std::string& what, double value) {
    result.status = JobStatus::failed;
    result.reason = fmt::format("{} is {:.3g}, which no measurement can be", what, value);
    result.responses.clear();
  };
  for (double* time : {&result.wall, &result.simulated}) {
    if (*time >= 0 && *time <= kLongest) continue;
    refuse("the time of the run", *time);
    *time = 0;
  }
  for (const Response& r : result.responses)
    for (const std::vector<double>* values : {&r.value, &r.uncertainty})
      for (const double v : *values)
        if (std::abs(v) > kLargest) {
          refuse("response " + r.name, v);
          return result;
        }
  return result;
}

std::optional<std::vector<double>> response_values(const JobResult& run, const std::string& name,
                                                   const std::string& unit) {
  const auto found = std::ranges::find(run.responses, name, &Response::name);
  if (found == run.responses.end()) return std::nullopt;
  if (found->unit == unit) return found->value;
  const std::optional<double> factor = conversion_factor(found->unit, unit);
  if (!factor) return std::nullopt;
  std::vector<double> values = found->value;
  for (double& value : values) value *= *factor;
  return values;
}

std::unique_ptr<Executor> local_executor(const LocalExecutorOptions& options) {
  return std::make_unique<LocalExecutor>(options);
}

}  // namespace firn
