// Execution of a batch of simulations: on this machine, on a cluster, or by a function of a test.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "experiments/case/case.h"
#include "experiments/results/response.h"

namespace firn {

// Limits of one run; 0: no limit.
struct RunLimits {
  double time = 0;    // s of wall time, all sessions of a resumed run together
  double memory = 0;  // bytes resident
};

struct Job {
  std::string key;                  // names the run's files; the same text has the same key
  std::string case_file;            // as written; `text` is what is run
  std::vector<Override> overrides;  // of the case file, seed included
  std::string text;                 // the complete case, as Executor::resolve() gave it
  std::string folder;               // where its files go
  int threads = 1;
  RunLimits limits;
  bool user_program = false;  // `text` describes the run of a program (program_run.h), not a case
};

enum class JobStatus {
  finished,
  arched,         // ended well, but the flow stopped by itself: a category, not a number
  failed,         // the simulation says why
  crashed,        // its process died; is repeated once
  timed_out,      // stopped at its limit of wall time: its response is unknown, not absent
  out_of_memory,  // killed at its limit of memory: the same
  // No outcomes: the run is repeated.
  lost,        // its process or its machine vanished for an external reason
  interrupted  // by the user
};
// Statuses that are stored in the journal.
inline constexpr JobStatus outcomes[] = {JobStatus::finished,  JobStatus::arched,
                                         JobStatus::failed,    JobStatus::crashed,
                                         JobStatus::timed_out, JobStatus::out_of_memory};
// Censored: with a higher limit there would have been a response.
inline bool cut_short(JobStatus status) {
  return status == JobStatus::timed_out || status == JobStatus::out_of_memory;
}
const char* to_string(JobStatus status);  // for messages and journals: "timed out", ...

struct JobResult {
  JobStatus status = JobStatus::failed;
  std::string reason;  // one sentence, for all but finished
  std::vector<Response> responses;
  double wall = 0;       // s
  double simulated = 0;  // s; reached by a run that was cut short
  double limit = 0;      // that cut it short: s or bytes
  std::string results_file = {};
};

// The same, or a failure that names the response, where one is beyond 1e30: such a number must not
// enter statistics and models of other runs. NaN, which stands for undefined, stays.
JobResult plausible(JobResult result);

// All values of a response of the run in this unit; nothing when the run does not have the
// response, or has it in a unit of another kind. Throws InputError for a text that is no unit.
std::optional<std::vector<double>> response_values(const JobResult& run, const std::string& name,
                                                   const std::string& unit);

struct JobEvents {
  std::function<void(const Job&)> started;
  std::function<void(const Job&, const JobResult&)> ended;
  std::function<void()> tick;                                // a few times a second
  std::function<void(const Job&, const std::string&)> note;  // one line about its files
};

class Executor {
 public:
  virtual ~Executor() = default;
  // The complete text of the case with these overrides and material records: the input of the run's
  // identity. Throws InputError when the overrides do not fit the case.
  virtual std::string resolve(const std::string& case_file, const std::vector<Override>& overrides,
                              const MaterialRequest& materials) = 0;
  // Carries out all jobs and reports each as it starts and ends; ended() never runs concurrently.
  // Resumes from the files of an earlier, killed attempt in the job's folder if possible.
  virtual void run(const std::vector<Job>& jobs, const JobEvents& events) = 0;
};

struct LocalExecutorOptions {
  std::string program;  // empty: the running executable
  int jobs = 0;         // processes side by side; 0: one per core
  const std::atomic<bool>* interrupt = nullptr;
};

std::string own_program();  // path of the running executable

// One process of `firn run` per job: a crash of one does not affect the others.
std::unique_ptr<Executor> local_executor(const LocalExecutorOptions& options);

}  // namespace firn
