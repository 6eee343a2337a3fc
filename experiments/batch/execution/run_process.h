// One run as a watched process of `firn run`. All executors start runs through this, so that limits
// apply in the same way on a workstation and on a cluster.
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

// Simulated time that the files of the run reach, s.
double simulated_time(const Job& job);

// Throws WriteError when a folder cannot take a file: full, read-only, gone.
void require_writable(const std::string& folder);

class RunProcess final : public RunningJob {
 public:
  using Note = std::function<void(const std::string&)>;  // gets one line for the user

  // Starts the run, or continues from its last checkpoint. The folder must hold no outcome of it.
  // Results that cannot be opened are renamed FILE.unreadable, and `print_note` gets a line that
  // says so.
  RunProcess(const Job& job, const std::string& program, Note print_note = {});
  // A run in progress saves its state and ends.
  ~RunProcess() override;
  RunProcess(const RunProcess&) = delete;
  RunProcess& operator=(const RunProcess&) = delete;

  const Job& job() const override { return job_; }
  void interrupt() override;  // it saves its state and ends
  // Looks at its limits; its result when it has ended. Throws RunError when it could not do its
  // work for reasons that lie around it, such as a full disk: that is no outcome.
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
  double earlier_ = 0;        // s of wall time in sessions before this
  Clock::time_point start_;
  Exceeded exceeded_ = Exceeded::nothing;
  Clock::time_point deadline_notified_;  // to end, for taking too long
  pid_t pid_ = -1;                       // -1: has ended
};

}  // namespace firn
