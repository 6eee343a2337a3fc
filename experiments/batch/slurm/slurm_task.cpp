#include "experiments/batch/slurm/slurm_task.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "experiments/batch/execution/program_process.h"
#include "experiments/batch/execution/run_process.h"
#include "experiments/batch/slurm/slurm_executor.h"
#include "experiments/system/input_file.h"
#include "experiments/system/interruption.h"
#include "experiments/system/output_file.h"
#include "experiments/system/terminal.h"
#include "experiments/text/json_fields.h"
#include "experiments/text/json_parser.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr auto look_every = std::chrono::milliseconds(100);

std::string outcome_file(const Job& job) {
  return (fs::path(job.folder) / (job.key + ".outcome")).string();
}

// Lock of a run. A node that was taken for lost may still simulate the run, so that a second task
// waits. The simulation inherits the lock.
class RunLock {
 public:
  explicit RunLock(const Job& job)
      : descriptor_(
            open((fs::path(job.folder) / (job.key + ".lock")).c_str(), O_RDWR | O_CREAT, 0644)) {
    if (descriptor_ < 0 || flock(descriptor_, LOCK_EX) != 0)
      throw RunError(fmt::format("{}: cannot be locked", job.folder));
  }
  ~RunLock() { close(descriptor_); }
  RunLock(const RunLock&) = delete;
  RunLock& operator=(const RunLock&) = delete;

 private:
  int descriptor_;
};

// The file of an array.
struct TaskList {
  std::string program;
  std::vector<Job> tasks;
};

}  // namespace

// The text of a job is in its case file.
template <class Fields>
static void fields(Fields& f, Job& job) {
  f.required("folder", job.folder);
  f.required("key", job.key);
  f.required("memory_limit", job.limits.memory);
  f.required("threads", PositiveInt{job.threads, 1024});
  f.required("time_limit", job.limits.time);
  f.required("user_program", job.user_program);
}

template <class Fields>
static void fields(Fields& f, TaskList& list) {
  f.required("program", list.program);
  f.required("tasks", list.tasks);
}

static Json json_value(JobStatus& status) { return to_string(status); }

static void read_json_value(const Json& json, const JsonPlace& place, JobStatus& status) {
  std::string word;
  JsonFieldReader::read(json, place, word);
  status = outcome_status(word).value_or(JobStatus::failed);
}

// Without responses: the results file has them.
template <class Fields>
static void fields(Fields& f, JobResult& outcome) {
  f.required("limit", outcome.limit);
  f.required("reason", outcome.reason);
  f.required("simulated", outcome.simulated);
  f.required("status", outcome.status);
  f.required("wall", outcome.wall);
}

namespace {

Job read_task(const std::string& file, int index, std::string& program) {
  auto list = document_from_json<TaskList>(
      read_json_file(file, "a list of tasks of firn calibrate"), JsonReading::strict);
  if (index < 0 || index >= static_cast<int>(list.tasks.size()))
    throw InputError(
        fmt::format("{}: holds no task {}; expected a list of firn calibrate", file, index));
  program = list.program;
  Job job = std::move(list.tasks[static_cast<std::size_t>(index)]);
  job.text = read_own_file(JobFiles(job).case_file);
  return job;
}

}  // namespace

void write_tasks(const std::string& file, const std::vector<Job>& jobs,
                 const std::string& program) {
  for (const Job& job : jobs) {
    make_own_folder(job.folder);
    write_own_file(JobFiles(job).case_file, job.text);
  }
  TaskList list{program, jobs};
  make_own_folder(fs::path(file).parent_path());
  write_own_file(file, json_text(list, 1) + '\n');
}

std::optional<JobResult> read_task_outcome(const Job& job) {
  const std::string file = outcome_file(job);
  if (std::error_code error; !fs::exists(file, error)) return std::nullopt;
  JobResult r;
  try {
    r = document_from_json<JobResult>(read_json_file(file, "an outcome of firn calibrate"),
                                      JsonReading::strict);
  } catch (const InputError&) {  // a part of it, on a shared folder
    return std::nullopt;
  }
  r.results_file = JobFiles(job).results;
  if (!holds_within(job.limits, r)) return std::nullopt;
  if (r.status != JobStatus::finished && r.status != JobStatus::arched) return r;
  // Of a program, the responses may be late on a shared folder; then they do not read as JSON or
  // CSV.
  if (job.user_program) {
    JobResult read = finished_program(job);
    read.wall = r.wall;
    if (read.status == JobStatus::failed) return std::nullopt;
    return read;
  }
  auto measured = existing_result(job);  // nothing: the shared folder does not show the results yet
  if (measured) measured->wall = r.wall;
  return measured;
}

void remove_task_outcome(const Job& job) { remove_if_there(outcome_file(job)); }

int run_slurm_task(const std::string& list, int index, const std::atomic<bool>* interrupt) {
  std::string program;
  const Job job = read_task(list, index, program);
  const RunLock lock(job);
  if (read_task_outcome(job)) return 0;  // another task has finished it
  auto result = existing_result(job);
  if (!result) {
    const interruption::Polled polled;
    const auto run = start_job(
        job, program, [](const std::string& line) { print_lines(stderr, "firn: {}\n", line); });
    bool stop_requested = false;
    while (!(result = run->poll())) {
      if (interrupt != nullptr && interrupt->load() && !stop_requested) run->interrupt();
      stop_requested = interrupt != nullptr && interrupt->load();
      std::this_thread::sleep_for(look_every);
    }
  }
  const bool stopped = interrupt != nullptr && interrupt->load();
  if (result->status == JobStatus::interrupted) return 130;
  if (result->status == JobStatus::lost && stopped) return 130;  // the signal came to both
  if (result->status == JobStatus::lost) throw RunError(result->reason);
  write_own_file(outcome_file(job), json_text(*result, -1));
  return 0;
}

}  // namespace firn
