// Runs a validation suite and compares it with measurements, as `firn validate` does.
#pragma once

#include <string>
#include <vector>

#include "experiments/batch/batch_folder.h"
#include "validation/comparison/comparison.h"

namespace firn {

struct ValidationOptions : BatchOptions {
  std::string suite_file;  // TOML
  std::string material;    // record in place of the suite's parameter sets; empty: these
  std::string database;    // of material records; empty: that of material_database_file()
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

std::string render_table(const Validation& validation);  // as text
std::string render_json(const Validation& validation);   // for programs, and for pages

}  // namespace firn
