// A running job: a process of `firn run` or of a user program.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "experiments/batch/execution/executor.h"

namespace firn {

// The destructor ends a job that is still running.
class RunningJob {
 public:
  virtual ~RunningJob() = default;
  virtual const Job& job() const = 0;
  virtual void interrupt() = 0;  // requests its end
  // Checks the limits of the job. Returns the result of a job that has ended. Throws RunError for
  // an external error such as a full disk.
  virtual std::optional<JobResult> poll() = 0;
};

// `program`: the firn executable, for all jobs but those of a user program. `print_note` gets one
// line for the user.
std::unique_ptr<RunningJob> start_job(const Job& job, const std::string& program,
                                      std::function<void(const std::string&)> print_note);

}  // namespace firn
