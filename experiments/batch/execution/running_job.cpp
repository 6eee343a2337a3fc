#include "experiments/batch/execution/running_job.h"

#include "experiments/batch/execution/program_process.h"
#include "experiments/batch/execution/run_process.h"

namespace firn {

std::unique_ptr<RunningJob> start_job(const Job& job, const std::string& program,
                                      std::function<void(const std::string&)> print_note) {
  if (job.user_program) return std::make_unique<ProgramProcess>(job);
  return std::make_unique<RunProcess>(job, program, std::move(print_note));
}

}  // namespace firn
