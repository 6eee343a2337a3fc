// Files that the executor and the tasks of a Slurm array exchange through the shared folder.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/batch/execution/executor.h"

namespace firn {

// Writes the list of the tasks of an array atomically.
void write_tasks(const std::string& file, const std::vector<Job>& jobs, const std::string& program);

// The outcome that a task wrote. Nothing without one, and for a run that exceeded limits below the
// current limits of the job.
std::optional<JobResult> read_task_outcome(const Job& job);
// To be called after the outcome is in the journal.
void remove_task_outcome(const Job& job);

}  // namespace firn
