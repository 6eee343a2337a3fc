// One run of a user program as a watched process in a separate folder, FOLDER/KEY/. The folder
// holds the filled template as `input_name`, links to the inputs (FOLDER/inputs/SHA-256), and what
// the program writes; its streams go to stdout.txt and stderr.txt.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <optional>
#include <string>

#include "experiments/batch/execution/program_run.h"
#include "experiments/batch/execution/running_job.h"

namespace firn {

// Path of the stored content of an input with this hash, below the folder of the runs.
std::string program_input_file(const std::string& runs_folder, const std::string& hash);

// The result of a program that ended with status 0, from the files of its run.
JobResult finished_program(const Job& job);

class ProgramProcess final : public RunningJob {
 public:
  // Recreates the folder and starts the program. Removes the files of an earlier attempt, whose
  // outcome is unknown.
  explicit ProgramProcess(const Job& job);
  // Kills the program and its children.
  ~ProgramProcess() override;
  ProgramProcess(const ProgramProcess&) = delete;
  ProgramProcess& operator=(const ProgramProcess&) = delete;

  const Job& job() const override { return job_; }
  void interrupt() override;
  std::optional<JobResult> poll() override;

 private:
  using Clock = std::chrono::steady_clock;
  enum class Exceeded { nothing, time, memory };

  void end();  // SIGTERM now, SIGKILL after a delay
  void watch_limits();
  double wall() const;  // s
  JobResult result(int status) const;

  Job job_;
  std::string folder_;
  Clock::time_point start_;
  std::optional<Clock::time_point> end_requested_;
  bool interrupted_ = false;
  Exceeded exceeded_ = Exceeded::nothing;
  pid_t pid_ = -1;  // of the process and of its group; -1: has ended
};

}  // namespace firn
