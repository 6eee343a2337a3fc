// validate(suite) -> comparisons: what `firn validate` does.
#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "experiments/batch/execution/executor.h"
#include "validation/comparison/comparison.h"

namespace firn {

struct ValidationOptions {
  std::string suite_file;          // TOML
  std::string directory;           // for journal, runs and results; empty: runs/<suite name>
  std::string material;            // record in place of the suite's parameter sets; empty: these
  std::string database;            // of material records; empty: as material_database_file() says
  int jobs = 0;                    // simulations side by side; 0: one per core
  bool resume = false;             // require that the directory holds this validation already
  std::string executor = "local";  // or "slurm"
  std::string program;             // the firn executable that simulates; empty: this one
  std::string store;               // file of the outcomes that batches share; empty: none
  bool show_progress = true, json_progress = false;
  const std::atomic<bool>* interrupt = nullptr;
  Executor* replace_executor = nullptr;  // not owned; a fake experiment, for tests
};

struct Validation {
  Suite suite;
  std::vector<RunGroup> groups;
  std::vector<Comparison> comparisons;  // by comparison of the suite, then by parameter set
  std::string directory, command;
  bool interrupted = false;
  int count(ValidationVerdict verdict) const;  // without comparisons of codes
};

// Runs or resumes the suite and writes results.json and runs.csv into the directory. Throws
// InputError for a wrong suite, a directory that holds something else, or one that another process
// is working in.
Validation validate(const ValidationOptions& options);

std::string render_table(const Validation& validation);  // for people
std::string render_json(const Validation& validation);   // for programs, and for pages

}  // namespace firn
