// Cache of outcomes that studies share. The key of a run is the hash of its complete case text
// (with parameters, seed and meshes) and of the identity of the program.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/batch/journal/journal.h"
#include "experiments/batch/journal/tables_file.h"

namespace firn {

class RunCache {
 public:
  // Opens or creates the file. Several processes of one machine may use it concurrently. `study`:
  // identity of the study whose runs are added. Throws InputError.
  explicit RunCache(const std::string& file, const std::string& study = "");

  std::optional<JobResult> find(const std::string& key);
  // Adds an outcome. It replaces the outcome of a run that exceeded its limits.
  void add(const PlannedRun& run, const JobResult& result);

  // Parameters (RunLabel::parameters) and seed of a run.
  struct Known {
    std::string parameters;
    std::uint64_t seed = 0;
  };
  // Runs that other studies added with this program, in the order of insertion.
  std::vector<Known> of_other_studies(const std::string& program);

 private:
  std::string study_;
  Database db_;
};

}  // namespace firn
