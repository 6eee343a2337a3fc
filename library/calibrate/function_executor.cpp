#include "library/calibrate/function_executor.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

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

struct Report {
  std::size_t job = 0;
  std::optional<JobResult> result;  // none: it has started
};

// Reports from threads to the one that reads them.
class ReportQueue {
 public:
  explicit ReportQueue(std::size_t threads) : at_work_(threads) {}

  void put(Report report) {
    const std::lock_guard lock(mutex_);
    reports_.push_back(std::move(report));
    changed_.notify_one();
  }
  // To be called once by each thread, last. `thrown`: what ended it; null: nothing.
  void end_thread(std::exception_ptr thrown) {
    const std::lock_guard lock(mutex_);
    if (thrown) thrown_ = std::move(thrown);
    --at_work_;
    changed_.notify_one();
  }

  // No thread is at work and all reports have been taken.
  bool is_over() const {
    const std::lock_guard lock(mutex_);
    return at_work_ == 0 && reports_.empty();
  }
  // The reports so far, in their order. Waits a moment for the first one.
  std::vector<Report> take() {
    std::unique_lock lock(mutex_);
    if (reports_.empty() && at_work_ > 0) changed_.wait_for(lock, std::chrono::milliseconds(200));
    return std::exchange(reports_, {});
  }
  // Throws what ended a thread.
  void rethrow() const {
    const std::lock_guard lock(mutex_);
    if (thrown_) std::rethrow_exception(thrown_);
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Report> reports_;
  std::exception_ptr thrown_;
  std::size_t at_work_;
};

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
  const std::size_t workers = std::min(jobs.size(), static_cast<std::size_t>(options_.jobs));
  ReportQueue queue(workers);
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    try {
      for (std::size_t job = next++; job < jobs.size() && !stop_; job = next++) {
        queue.put({job, {}});
        queue.put({job, simulate(jobs[job])});
      }
      queue.end_thread(nullptr);
    } catch (...) {
      stop_ = true;
      queue.end_thread(std::current_exception());
    }
  };
  std::vector<std::jthread> threads;
  for (std::size_t i = 0; i < workers; ++i) threads.emplace_back(work);
  try {
    while (!queue.is_over()) {
      for (const Report& r : queue.take()) {
        if (r.result)
          events.ended(jobs[r.job], *r.result);
        else
          events.started(jobs[r.job]);
      }
      events.tick();
      should_continue();
    }
  } catch (...) {
    stop_ = true;  // threads end before this function is left
    throw;
  }
  queue.rethrow();
}

}  // namespace firn::calibration
