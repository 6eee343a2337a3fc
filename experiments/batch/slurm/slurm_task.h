// Files that the executor and the tasks of a Slurm array exchange through the shared folder.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/batch/execution/executor.h"

namespace firn {

// The list of the tasks of an array. Written whole or not at all.
void write_tasks(const std::string& file, const std::vector<Job>& jobs, const std::string& program);

// The outcome that a task left; nothing while there is none, and for one that was cut short by less
// than the job may take now.
std::optional<JobResult> read_task_outcome(const Job& job);
// Once it is in the journal.
void remove_task_outcome(const Job& job);

}  // namespace firn
