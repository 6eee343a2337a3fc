// Executes a set of runs: reads known outcomes from the journal and the run cache, simulates the
// others, and stores every outcome immediately.
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "experiments/batch/execution/executor.h"
#include "experiments/batch/execution/program_run.h"
#include "experiments/batch/journal/journal.h"
#include "experiments/batch/journal/run_cache.h"
#include "experiments/batch/progress.h"

namespace firn {

// A run of a batch. Runs of equal complete case texts have equal keys and are executed once.
struct BatchRun {
  Job job;
  PlannedRun planned;
};

// Thrown when the user has interrupted the batch. All finished runs are in the journal.
struct BatchInterrupted {};

class Batch {
 public:
  // Called once with every outcome, as soon as it is known. An exception ends the batch.
  using Check = std::function<void(const BatchRun&, const JobResult&)>;

  // `store`: run cache; null: none.
  Batch(Executor& executor, Journal& journal, RunCache* store, BatchProgress& progress,
        const std::atomic<bool>* interrupt);

  // A run of a case file with these overrides, which include the seed. `folder`: of its files.
  // Throws InputError for overrides that do not fit the case.
  BatchRun make(const std::string& case_file, const std::vector<Override>& overrides,
                const std::string& folder, const RunLabel& label,
                const MaterialRequest& materials = {}) const;

  // A run of a user program; its files are in a separate folder below `folder`.
  BatchRun make(const ProgramRun& program, const std::string& folder, const RunLabel& label) const;

  // Throws BatchInterrupted, and RunError when runs are lost repeatedly.
  void run(const std::vector<BatchRun>& runs, const Check& check = {});

  // Outcome of a run that has ended.
  const JobResult& outcome(const std::string& key) const { return outcomes_.at(key); }
  const std::string& program() const { return program_; }  // that simulates

 private:
  using RunsByKey = std::map<std::string, const BatchRun*>;
  std::optional<JobResult> known_outcome(const BatchRun& run);
  void simulate(std::vector<Job> jobs, const RunsByKey& runs, const Check& check);

  Executor& executor_;
  Journal& journal_;
  RunCache* store_;
  BatchProgress& progress_;
  const std::atomic<bool>* interrupt_;
  std::string program_;
  std::map<std::string, JobResult> outcomes_;  // by key, as the journal has them
};

}  // namespace firn
