// Execution of runs on a Slurm cluster: one job array per batch. Slurm schedules the runs, and
// repeats a run whose node has failed.
#pragma once

#include <memory>
#include <string>

#include "experiments/batch/execution/execution_settings.h"
#include "experiments/batch/execution/executor.h"
#include "experiments/batch/journal/journal.h"

namespace firn {

struct SlurmOptions {
  SlurmSettings settings;
  std::string program;       // firn executable that simulates, path on the nodes; empty: this one
  std::string task_program;  // firn executable of the tasks, path on the nodes; empty: this one
  std::string folder;        // absolute path; for task lists and the output of Slurm
  int at_once = 0;           // concurrent tasks of an array; 0: all
  int largest_array = 1000;  // tasks; the default limit of Slurm is 1001
  double file_timeout = 60;  // s, largest delay of files on a shared file system
  const std::atomic<bool>* interrupt = nullptr;
};

// The journal stores every array from before its submission to the end of its tasks. After a kill,
// a study finds its arrays by name and does not submit a run twice.
std::unique_ptr<Executor> slurm_executor(const SlurmOptions& options, Journal& journal);

// Called on a node: executes task `index` of a list that the executor wrote, and writes its outcome
// to the folder of the results. Returns the exit status.
int run_slurm_task(const std::string& list, int index, const std::atomic<bool>* interrupt);

}  // namespace firn
