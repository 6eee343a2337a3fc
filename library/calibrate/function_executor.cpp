#include "library/calibrate/function_executor.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <queue>
#include <thread>

#include "experiments/case_reader/read_case.h"
#include "firn/math.h"

namespace firn::calibration {
namespace {

constexpr char kSeed[] = "case.seed";

// Of "0.2" or "\"0.2 mm\"", as overrides_of() writes them.
double number_of(const std::string& value) {
  double number = 0;
  const char* begin = value.data() + (value.starts_with('"') ? 1 : 0);
  std::from_chars(begin, value.data() + value.size(), number);
  return number;
}

}  // namespace

ResolvedCase FunctionExecutor::resolve(const std::string&, const std::vector<Override>& overrides,
                                       const MaterialRequest&) {
  std::string text = fmt::format("simulator = {}\n", options_.simulator_version);
  for (const auto& [key, value] : overrides) text += key + " = " + value + "\n";
  return {text, case_identity(text)};
}

JobResult FunctionExecutor::simulate(const Job& job) const {
  std::map<std::string, double> values;
  std::uint64_t seed = 0;
  for (const auto& [key, value] : job.overrides) {
    if (key == kSeed)
      std::from_chars(value.data(), value.data() + value.size(), seed);
    else
      values[key] = number_of(value);
  }
  JobResult result;
  result.status = JobStatus::finished;
  const auto start = std::chrono::steady_clock::now();
  try {
    for (const Response& r : simulator_(values, seed))
      result.responses.push_back({r.name, {r.value}, {}, r.unit, "function of the caller", 1});
  } catch (const RunError& e) {
    result.status = JobStatus::failed;
    result.reason = e.what();
  }
  result.wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

bool FunctionExecutor::should_continue() {
  if (!stop_ && options_.keep_going && !options_.keep_going()) stop_ = true;
  return !stop_;
}

void FunctionExecutor::run(const std::vector<Job>& jobs, const JobEvents& events) {
  if (options_.jobs > 1)
    run_on_threads(jobs, events);
  else
    run_here(jobs, events);
}

void FunctionExecutor::run_here(const std::vector<Job>& jobs, const JobEvents& events) {
  for (const Job& job : jobs) {
    if (!should_continue()) return;
    events.started(job);
    events.ended(job, simulate(job));
    events.tick();
  }
}

// Threads simulate; the calling thread alone reports.
void FunctionExecutor::run_on_threads(const std::vector<Job>& jobs, const JobEvents& events) {
  struct Report {
    std::size_t job;
    std::optional<JobResult> result;  // none: it has started
  };
  std::mutex mutex;
  std::condition_variable reported;
  std::queue<Report> reports;
  std::exception_ptr thrown;
  std::size_t at_work = std::min(jobs.size(), static_cast<std::size_t>(options_.jobs));
  std::atomic<std::size_t> next = 0;
  const auto report = [&](Report r) {
    const std::lock_guard lock(mutex);
    reports.push(std::move(r));
    reported.notify_one();
  };
  const auto work = [&] {
    try {
      for (std::size_t job = next++; job < jobs.size() && !stop_; job = next++) {
        report({job, {}});
        report({job, simulate(jobs[job])});
      }
    } catch (...) {
      const std::lock_guard lock(mutex);
      thrown = std::current_exception();
      stop_ = true;
    }
    const std::lock_guard lock(mutex);
    --at_work;
    reported.notify_one();
  };
  const std::size_t workers = at_work;
  std::vector<std::jthread> threads;
  for (std::size_t i = 0; i < workers; ++i) threads.emplace_back(work);
  std::unique_lock lock(mutex);
  while (at_work > 0 || !reports.empty()) {
    reported.wait_for(lock, std::chrono::milliseconds(200));
    while (!reports.empty()) {
      const Report r = std::move(reports.front());
      reports.pop();
      lock.unlock();
      try {
        if (r.result)
          events.ended(jobs[r.job], *r.result);
        else
          events.started(jobs[r.job]);
      } catch (...) {
        stop_ = true;  // threads end before this function is left
        throw;
      }
      lock.lock();
    }
    lock.unlock();
    try {
      events.tick();
      should_continue();
    } catch (...) {
      stop_ = true;
      throw;
    }
    lock.lock();
  }
  if (thrown) std::rethrow_exception(thrown);
}

}  // namespace firn::calibration
