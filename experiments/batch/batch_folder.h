// The folder of a study, a validation or a sweep: lock, journal, executor and progress.
#pragma once

#include <fmt/format.h>

#include <atomic>
#include <memory>
#include <optional>
#include <string>

#include "experiments/batch/batch.h"
#include "experiments/batch/execution/execution_settings.h"
#include "experiments/system/output_file.h"

namespace firn {

// Lock of a directory for one process. Simulations inherit the lock. Simulations that outlive a
// killed batch hold it until they have saved their state; the constructor waits for them.
class DirectoryLock {
 public:
  // Throws InputError when another process holds the lock.
  explicit DirectoryLock(const std::string& directory);
  ~DirectoryLock();
  DirectoryLock(const DirectoryLock&) = delete;
  DirectoryLock& operator=(const DirectoryLock&) = delete;

 private:
  int descriptor_ = -1;
};

// How the runs of a study, a validation or a sweep are executed.
struct BatchOptions {
  std::string directory;           // for journal, runs and results; empty: runs/<name>
  int jobs = 0;                    // concurrent simulations; 0: one per core
  bool resume = false;             // the directory must contain this batch
  std::string executor = "local";  // or "slurm"
  std::string program;             // the firn executable that simulates; empty: this one
  std::string store;               // file of the run cache; empty: none
  bool show_progress = true;       // on standard error
  bool json_progress = false;      // as JSON, one event a line
  const std::atomic<bool>* interrupt = nullptr;  // set from a signal handler: save and stop
  Executor* replace_executor = nullptr;          // for tests; not owned
};

// What a folder holds.
struct BatchContent {
  std::string kind;       // "calibrate", "sweep", ...: prefix of lines of progress
  std::string identity;   // text that identifies the batch; a journal with another one is rejected
  int largest_total = 0;  // largest number of runs
  SlurmSettings slurm;
};

// States that finished runs are saved in `directory`. `condition`: what the user must do before the
// command resumes, such as "free space and "; may be empty.
inline std::string resume_hint(const std::string& directory, const std::string& condition = "") {
  return fmt::format("everything finished is kept in {}: {}the same command resumes", directory,
                     condition);
}

// Returns work(). Adds to a WriteError that finished runs are saved in `directory`.
template <class Work>
auto with_kept_runs(const std::string& directory, Work&& work) {
  try {
    return work();
  } catch (const WriteError& e) {
    throw WriteError(e, resume_hint(directory, remedy(e.error)));
  }
}

class BatchFolder {
 public:
  // `directory` replaces that of the options. Throws InputError for a folder with other content and
  // for one that another process has locked.
  BatchFolder(const std::string& directory, const BatchContent& content,
              const BatchOptions& options);

  Executor& executor() { return *executor_; }
  Journal& journal() { return *journal_; }
  RunCache* store() { return store_ ? &*store_ : nullptr; }
  BatchProgress& progress() { return *progress_; }
  const std::string& runs() const { return runs_; }  // absolute path; results files go there

 private:
  std::optional<DirectoryLock> lock_;
  std::optional<Journal> journal_;
  std::optional<RunCache> store_;
  std::unique_ptr<Executor> own_;
  Executor* executor_;
  std::optional<BatchProgress> progress_;
  std::string runs_;
};

}  // namespace firn
