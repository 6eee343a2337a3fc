// Interface for the execution of runs: on this machine, on a cluster, or by a function in tests.
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
  double time = 0;    // s of wall time, sum of all sessions
  double memory = 0;  // bytes of resident memory
};

struct Job {
  std::string key;                  // base name of the files; equal texts have equal keys
  std::string case_file;            // as stated by the user; `text` is executed
  std::vector<Override> overrides;  // of the case file, with the seed
  std::string text;                 // the complete case from Executor::resolve()
  std::string folder;               // of its files
  int threads = 1;
  RunLimits limits;
  bool user_program = false;  // `text` describes the run of a program (program_run.h), not a case
};

enum class JobStatus {
  finished,
  arched,         // finished, but particles arched over the outlet: a category, not a number
  failed,         // the simulation reported an error
  crashed,        // its process crashed; repeated once
  timed_out,      // stopped at its limit of wall time: responses are censored
  out_of_memory,  // killed at its limit of memory: responses are censored
  // Not outcomes: the run is repeated.
  lost,        // its process or machine was lost for an external reason
  interrupted  // by the user
};
// Statuses that are stored in the journal.
inline constexpr JobStatus outcomes[] = {JobStatus::finished,  JobStatus::arched,
                                         JobStatus::failed,    JobStatus::crashed,
                                         JobStatus::timed_out, JobStatus::out_of_memory};
// Censored: a higher limit would have given responses.
inline bool cut_short(JobStatus status) {
  return status == JobStatus::timed_out || status == JobStatus::out_of_memory;
}
const char* to_string(JobStatus status);  // for messages and journals: "timed out", ...
// The inverse for outcomes; nothing for any other text.
std::optional<JobStatus> outcome_status(const std::string& text);

struct JobResult {
  JobStatus status = JobStatus::failed;
  std::string reason;  // one sentence, for all but finished
  std::vector<Response> responses;
  double wall = 0;       // s
  double simulated = 0;  // s, simulated time
  double limit = 0;      // limit that was exceeded, s or bytes
  std::string results_file = {};
};

// Whether a run with these limits would have this outcome: false for a run that was stopped at a
// lower limit.
bool holds_within(const RunLimits& limits, const JobResult& result);

// Returns `result`, or a failure that names the response if a value exceeds 1e30 in magnitude: such
// a number must not enter statistics and surrogates. NaN (undefined) is accepted.
JobResult plausible(JobResult result);

// All values of a response in `unit`. Nothing if the run does not have the response, or if its unit
// has another dimension. Throws InputError for a text that is not a unit.
std::optional<std::vector<double>> response_values(const JobResult& run, const std::string& name,
                                                   const std::string& unit);

struct JobEvents {
  std::function<void(const Job&)> started;
  std::function<void(const Job&, const JobResult&)> ended;
  std::function<void()> tick;                                // a few times a second
  std::function<void(const Job&, const std::string&)> note;  // one message about its files
};

// A run before it is simulated.
struct ResolvedCase {
  std::string text;      // complete: what is executed
  std::string identity;  // case_identity(text), from which the key of the run is computed
};

class Executor {
 public:
  virtual ~Executor() = default;
  // The case with these overrides and material records, as read_case() completes it. Throws
  // InputError for overrides that do not fit the case.
  virtual ResolvedCase resolve(const std::string& case_file, const std::vector<Override>& overrides,
                               const MaterialRequest& materials);
  // Executes all jobs and reports the start and the end of each. ended() is not called
  // concurrently. Resumes from the files of an earlier killed attempt in the folder of the job if
  // possible.
  virtual void run(const std::vector<Job>& jobs, const JobEvents& events) = 0;
};

struct LocalExecutorOptions {
  std::string program;  // empty: the running executable
  int jobs = 0;         // concurrent processes; 0: one per core
  const std::atomic<bool>* interrupt = nullptr;
};

std::string current_executable();  // path of the running executable

// One process of `firn run` per job: a crash of one does not affect the others.
std::unique_ptr<Executor> local_executor(const LocalExecutorOptions& options);

}  // namespace firn
