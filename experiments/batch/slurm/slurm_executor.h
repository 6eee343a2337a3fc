// Runs on an existing Slurm cluster: one job array per batch. No scheduler of our own: Slurm
// decides when and where a run takes place, and runs it again when its node is lost.
#pragma once

#include <memory>
#include <string>

#include "experiments/batch/execution/execution_settings.h"
#include "experiments/batch/execution/executor.h"
#include "experiments/batch/journal/journal.h"

namespace firn {

struct SlurmOptions {
  SlurmSettings settings;
  std::string program;       // that simulates, path on the nodes; empty: the running executable
  std::string task_program;  // a firn, the same; empty: the running executable
  std::string folder;        // absolute; lists of tasks and Slurm's own output go there
  int at_once = 0;           // tasks of an array that may run side by side; 0: all
  int largest_array =
      1000;  // tasks; Slurm's own limit is 1001 unless its administrator says otherwise
  double file_timeout = 60;  // s that a shared folder may take to show what a task wrote
  const std::atomic<bool>* interrupt = nullptr;
};

// The journal stores every array before its submission until its tasks are done: a study that was
// killed finds them again by name, and never submits a run twice.
std::unique_ptr<Executor> slurm_executor(const SlurmOptions& options, Journal& journal);

// Runs on a node: executes task `index` of a list that the executor wrote and writes its outcome
// into the folder of the results. Returns the exit status.
int run_slurm_task(const std::string& list, int index, const std::atomic<bool>* interrupt);

}  // namespace firn
