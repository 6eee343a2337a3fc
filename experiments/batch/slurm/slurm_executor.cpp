#include "experiments/batch/slurm/slurm_executor.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <thread>

#include "experiments/batch/execution/run_process.h"
#include "experiments/batch/slurm/slurm_task.h"
#include "experiments/storage/sha256.h"
#include "experiments/system/process.h"
#include "experiments/system/text_encoding.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr auto tick_every = std::chrono::milliseconds(20);
// Slurm's own limits lie above those of the run, which stop it with its state saved.
constexpr double time_headroom = 300;                  // s: for the start and for saving
constexpr double memory_headroom = 256.0 * (1 << 20);  // bytes: for what watches the run

// One that has left the queue, or is about to.
bool over(const std::string& state) {
  static const std::set<std::string> under_way = {
      "PENDING",      "RUNNING",   "CONFIGURING", "COMPLETING",  "SUSPENDED",
      "STOPPED",      "REQUEUED",  "RESIZING",    "REQUEUE_FED", "REQUEUE_HOLD",
      "SPECIAL_EXIT", "STAGE_OUT", "SIGNALING"};
  return !under_way.contains(state);
}

class SlurmExecutor final : public Executor {
 public:
  SlurmExecutor(const SlurmOptions& options, Journal& journal)
      : options_(options), journal_(journal) {
    if (options_.program.empty()) options_.program = current_executable();
    if (options_.task_program.empty()) options_.task_program = current_executable();
  }

  void run(const std::vector<Job>& jobs, const JobEvents& events) override {
    Tasks tasks;
    for (const Job& job : jobs) tasks[job.key].job = job;
    find_earlier_arrays();
    take_outcomes(tasks, events);
    attach(tasks, events);
    try {
      submit_missing(jobs, tasks, events);
      while (!tasks.empty() && !interrupted()) {
        wait(events);
        query_queue();
        take_outcomes(tasks, events);
        mark_vanished_lost(tasks, events);
      }
    } catch (...) {
      cancel();  // the outcomes of the tasks are not used any more
      throw;
    }
    if (interrupted()) {
      cancel();
      for (const auto& [key, task] : tasks)
        if (task.started) events.ended(task.job, {JobStatus::interrupted, "interrupted", {}});
    }
    forget_finished_arrays(tasks);
  }

 private:
  struct Task {
    Job job;
    bool started = false;
    Clock::time_point gone{};  // when it was first seen to have left the queue
    std::string last_state;
  };
  using Tasks = std::map<std::string, Task>;  // by key; those without an outcome so far

  bool interrupted() const { return options_.interrupt != nullptr && options_.interrupt->load(); }

  // Finds the arrays of an earlier session that ended early. If the journal has no job number of an
  // array, the queue is searched for its name. An array that is not in the queue was never
  // submitted.
  void find_earlier_arrays() {
    arrays_.clear();
    for (const Submission& s : journal_.submissions()) arrays_[s.name] = s;
    query_queue();
    if (!answered_)
      throw RunError(fmt::format(
          "Slurm does not answer ({}), and may be at work on this study; the same command resumes "
          "once it does",
          trouble_));
    for (auto& [name, array] : arrays_) {
      if (!array.job.empty()) continue;
      const auto found = numbers_.find(name);
      if (found == numbers_.end()) continue;
      array.job = found->second;
      journal_.submit(array);
    }
    std::erase_if(arrays_, [&](const auto& item) {
      if (!item.second.job.empty()) return false;
      journal_.forget_submission(item.first);
      return true;
    });
  }

  // States of all tasks of our arrays, by key. Throws RunError only when there is no squeue.
  void query_queue() {
    answered_ = false;
    if (arrays_.empty()) {
      states_.clear();
      answered_ = true;
      return;
    }
    std::vector<std::string> names;
    for (const auto& [name, array] : arrays_) names.push_back(name);
    const CommandResult r =
        run_command({"squeue", "--noheader", "--array", "--states=all",
                     fmt::format("--name={}", fmt::join(names, ",")), "--format=%j|%F|%K|%T"});
    if (r.status == 127) throw RunError("squeue: not found; is this a machine of a Slurm cluster?");
    if (r.status != 0) {  // no answer: the states of the last query stay
      trouble_ = last_line(r.err);
      return;
    }
    answered_ = true;
    states_.clear();
    std::istringstream lines(r.out);
    for (std::string line; std::getline(lines, line);) {
      std::istringstream fields(line);
      std::string name, number, index, state;
      if (!std::getline(fields, name, '|') || !std::getline(fields, number, '|') ||
          !std::getline(fields, index, '|') || !std::getline(fields, state, '|'))
        continue;
      const auto array = arrays_.find(name);
      if (array == arrays_.end()) continue;
      numbers_[name] = number;
      const std::size_t i = std::strtoul(index.c_str(), nullptr, 10);
      if (i < array->second.keys.size()) states_[array->second.keys[i]] = state;
    }
  }

  void start(Task& task, const JobEvents& events) {
    if (!task.started) events.started(task.job);
    task.started = true;
  }

  void take_outcomes(Tasks& tasks, const JobEvents& events) {
    for (auto item = tasks.begin(); item != tasks.end();) {
      Task& task = item->second;
      const auto result = read_task_outcome(task.job);
      if (!result) {
        ++item;
        continue;
      }
      start(task, events);
      events.ended(task.job, *result);
      remove_task_outcome(task.job);
      item = tasks.erase(item);
    }
  }

  // Tasks that a session before this one handed over.
  void attach(Tasks& tasks, const JobEvents& events) {
    for (const auto& [name, array] : arrays_)
      for (const std::string& key : array.keys) {
        const auto task = tasks.find(key);
        if (task == tasks.end()) continue;
        const auto state = states_.find(key);
        if (state != states_.end() && !over(state->second)) start(task->second, events);
      }
  }

  void submit_missing(const std::vector<Job>& jobs, Tasks& tasks, const JobEvents& events) {
    std::vector<Job> missing;
    for (const Job& job : jobs) {
      const auto task = tasks.find(job.key);
      if (task != tasks.end() && !task->second.started) missing.push_back(job);
    }
    const std::size_t most = static_cast<std::size_t>(options_.largest_array);
    for (std::size_t first = 0; first < missing.size() && !interrupted(); first += most) {
      const std::size_t last = std::min(missing.size(), first + most);
      const std::vector<Job> part(missing.begin() + static_cast<std::ptrdiff_t>(first),
                                  missing.begin() + static_cast<std::ptrdiff_t>(last));
      submit(part);
      for (const Job& job : part) start(tasks.at(job.key), events);
    }
  }

  // The journal stores the array before its submission, and Slurm's reply afterwards.
  void submit(const std::vector<Job>& jobs) {
    Submission array;
    for (const Job& job : jobs) {
      array.keys.push_back(job.key);
      remove_task_outcome(job);  // cut short by a lower limit
      states_.erase(job.key);
    }
    array.name = unique_name();
    const std::string list = (fs::path(options_.folder) / (array.name + ".json")).string();
    write_tasks(list, jobs, options_.program);
    journal_.submit(array);
    const CommandResult r = run_command(sbatch(array, jobs.front(), list));
    if (r.status != 0) {
      journal_.forget_submission(array.name);
      throw RunError(r.status == 127 ? "sbatch: not found; is this a machine of a Slurm cluster?"
                                     : fmt::format("sbatch takes no jobs: {}", last_line(r.err)));
    }
    array.job = r.out.substr(0, r.out.find_first_of(";\n"));  // JOB or JOB;CLUSTER
    arrays_[array.name] = array;
    journal_.submit(array);
  }

  // Of this study alone, and never used before.
  std::string unique_name() const {
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    return "firn-" +
           sha256(fmt::format("{} {}", options_.folder,
                              std::chrono::duration_cast<std::chrono::nanoseconds>(now).count()))
               .substr(0, 16);
  }

  std::vector<std::string> sbatch(const Submission& array, const Job& job,
                                  const std::string& list) const {
    const SlurmSettings& s = options_.settings;
    std::vector<std::string> args = {
        "sbatch",
        "--parsable",
        "--requeue",
        "--open-mode=append",
        "--job-name=" + array.name,
        fmt::format("--array=0-{}{}", array.keys.size() - 1,
                    options_.at_once > 0 ? fmt::format("%{}", options_.at_once) : ""),
        fmt::format("--cpus-per-task={}", job.threads),
        "--output=" + (fs::path(options_.folder) / (array.name + "-%a.log")).string(),
        "--chdir=" + options_.folder};
    if (job.limits.time > 0)
      args.push_back(
          fmt::format("--time={:.0f}", std::ceil((job.limits.time + time_headroom) / 60)));
    if (job.limits.memory > 0)
      args.push_back(fmt::format("--mem={:.0f}M",
                                 std::ceil((job.limits.memory + memory_headroom) / (1 << 20))));
    if (!s.partition.empty()) args.push_back("--partition=" + s.partition);
    if (!s.account.empty()) args.push_back("--account=" + s.account);
    args.insert(args.end(), s.options.begin(), s.options.end());
    args.push_back(fmt::format("--wrap=exec {} slurm-task {} $SLURM_ARRAY_TASK_ID",
                               encode::shell_word(options_.task_program),
                               encode::shell_word(list)));
    return args;
  }

  void wait(const JobEvents& events) const {
    const auto until = Clock::now() + std::chrono::duration<double>(options_.settings.poll);
    while (Clock::now() < until && !interrupted()) {
      if (events.tick) events.tick();
      std::this_thread::sleep_for(tick_every);
    }
  }

  // A task that has left the queue without an outcome, for longer than a shared folder takes to
  // show one, is lost: its node died, it was canceled, or its partition's time was up.
  void mark_vanished_lost(Tasks& tasks, const JobEvents& events) {
    if (!answered_) return;
    const auto now = Clock::now();
    for (auto item = tasks.begin(); item != tasks.end();) {
      Task& task = item->second;
      const auto state = states_.find(item->first);
      if (state != states_.end()) task.last_state = state->second;
      if (state != states_.end() && !over(state->second))
        task.gone = {};
      else if (task.gone == Clock::time_point{})
        task.gone = now;
      if (task.gone == Clock::time_point{} ||
          now - task.gone < std::chrono::duration<double>(options_.file_timeout)) {
        ++item;
        continue;
      }
      events.ended(task.job, vanished(task.job, task.last_state));
      item = tasks.erase(item);
    }
  }

  JobResult vanished(const Job& job, const std::string& last_state) const {
    for (const auto& [name, array] : arrays_)
      for (std::size_t i = 0; i < array.keys.size(); ++i) {
        if (array.keys[i] != job.key) continue;
        const std::string task = fmt::format("{}_{}", array.job, i);
        const std::string log = last_line_of_file(
            (fs::path(options_.folder) / fmt::format("{}-{}.log", name, i)).string());
        return {JobStatus::lost,
                fmt::format("Slurm's task {} ended without an outcome ({}{}{})", task,
                            final_state(task, last_state), log.empty() ? "" : ": ", log),
                {},
                0,
                simulated_time(job)};
      }
    return {JobStatus::lost, "vanished from the cluster", {}};
  }

  // The accounting, where there is one, lists it longer than the queue.
  static std::string final_state(const std::string& task, const std::string& last_state) {
    const CommandResult r =
        run_command({"sacct", "--noheader", "--parsable2", "-X", "--format=State", "-j", task});
    const std::string state = r.status == 0 ? last_line(r.out) : "";
    if (!state.empty()) return state;
    return last_state.empty() ? "no longer in the queue" : last_state;
  }

  void cancel() {
    for (const auto& [name, array] : arrays_)
      if (run_command({"scancel", array.job}).status == 0) journal_.forget_submission(name);
  }

  void forget_finished_arrays(const Tasks& tasks) {
    if (!tasks.empty()) return;
    for (const auto& [name, array] : arrays_) journal_.forget_submission(name);
    arrays_.clear();
  }

  SlurmOptions options_;
  Journal& journal_;
  std::map<std::string, Submission> arrays_;    // by name; those that may be under way
  std::map<std::string, std::string> states_;   // by key, at the last query of the queue
  std::map<std::string, std::string> numbers_;  // of arrays in the queue, by name
  bool answered_ = false;                       // whether the last query succeeded
  std::string trouble_;                         // error message of a failed query
};

}  // namespace

std::unique_ptr<Executor> slurm_executor(const SlurmOptions& options, Journal& journal) {
  return std::make_unique<SlurmExecutor>(options, journal);
}

}  // namespace firn
