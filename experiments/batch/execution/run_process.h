// One run as a process of `firn run` with limits. All executors start runs with this class, so that
// limits apply in the same way on a workstation and on a cluster.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <functional>
#include <optional>
#include <string>

#include "experiments/batch/execution/running_job.h"

namespace firn {

struct JobFiles {
  explicit JobFiles(const Job& job);
  std::string case_file, results, log;
};

// Outcome of a run according to its files; nothing while it has not ended.
std::optional<JobResult> existing_result(const Job& job);

// Simulated time in the files of the run, s.
double simulated_time(const Job& job);

// Throws WriteError when no file can be written to the folder: full, read-only, missing.
void require_writable(const std::string& folder);

class RunProcess final : public RunningJob {
 public:
  using Note = std::function<void(const std::string&)>;  // gets one line for the user

  // Starts the run or continues from its last checkpoint. The folder must not have its outcome.
  // Results that cannot be opened are renamed FILE.unreadable, which is reported to `print_note`.
  RunProcess(const Job& job, const std::string& program, Note print_note = {});
  // A run in progress saves its state and ends.
  ~RunProcess() override;
  RunProcess(const RunProcess&) = delete;
  RunProcess& operator=(const RunProcess&) = delete;

  const Job& job() const override { return job_; }
  void interrupt() override;  // the run saves its state and ends
  // See RunningJob. An external error such as a full disk throws RunError and is not an outcome.
  std::optional<JobResult> poll() override;

 private:
  using Clock = std::chrono::steady_clock;
  enum class Exceeded { nothing, time, memory };

  void send(int signal);
  void note(const std::string& line) const;
  double wall() const;  // s, all sessions
  void watch_limits();
  JobResult result(int status) const;
  JobResult cut(JobStatus status, double limit, const std::string& limit_text) const;

  Job job_;
  JobFiles files_;
  Note print_note_;
  bool resumed_ = false;      // from a checkpoint of an earlier session
  bool interrupted_ = false;  // by interrupt()
  double earlier_ = 0;        // s of wall time in earlier sessions
  Clock::time_point start_;
  Exceeded exceeded_ = Exceeded::nothing;
  Clock::time_point deadline_notified_;  // when its end was requested at the time limit
  pid_t pid_ = -1;                       // -1: has ended
};

}  // namespace firn
