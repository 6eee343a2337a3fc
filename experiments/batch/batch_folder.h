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

// Lock of a directory: one process at a time works in it. Simulations inherit the lock. Simulations
// that outlive a killed batch keep it until they have saved their state, and the constructor waits
// for them.
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
  int jobs = 0;                    // simulations side by side; 0: one per core
  bool resume = false;             // require that the directory holds this batch already
  std::string executor = "local";  // or "slurm"
  std::string program;             // the firn executable that simulates; empty: this one
  std::string store;               // file of the outcomes that batches share; empty: none
  bool show_progress = true;       // on standard error
  bool json_progress = false;      // as JSON, one event a line
  const std::atomic<bool>* interrupt = nullptr;  // set from a signal handler: save and stop
  Executor* replace_executor = nullptr;          // not owned; a fake experiment, for tests
};

struct BatchFolderOptions {
  std::string directory;
  std::string identity;  // text that the journal belongs to; another one is refused
  bool must_exist = false;
  std::string executor = "local";  // or "slurm"
  std::string program;             // the firn executable that simulates; empty: this one
  int jobs = 0;                    // simulations side by side; 0: one per core
  std::string store;               // file of the outcomes that batches share; empty: none
  SlurmSettings slurm;
  ProgressStyle progress = ProgressStyle::text;
  std::string progress_name;  // what plain lines of progress begin with
  int largest_total = 0;      // runs at most
  const std::atomic<bool>* interrupt = nullptr;
  Executor* replace_executor = nullptr;  // not owned; a fake experiment, for tests
};

// The options of a folder for batch `kind` ("sweep"). `identity`: text that the journal belongs to.
BatchFolderOptions folder_options(const BatchOptions& options, const std::string& kind,
                                  const std::string& identity, const std::string& directory,
                                  int largest_total, const SlurmSettings& slurm);

// Returns work(). A WriteError gets what is safe: the finished runs in the journal of `directory`.
template <class Work>
auto with_kept_runs(const std::string& directory, Work&& work) {
  try {
    return work();
  } catch (const WriteError& e) {
    throw WriteError(e, fmt::format("everything finished is kept in {}: {}the same command "
                                    "resumes",
                                    directory, remedy(e.error)));
  }
}

class BatchFolder {
 public:
  // Throws InputError for a folder that holds something else or that another process is working in.
  explicit BatchFolder(const BatchFolderOptions& options);

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
