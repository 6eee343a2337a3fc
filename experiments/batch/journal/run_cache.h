// Outcomes that studies share: a run is found by the hash of its complete case text (parameters,
// seed and meshes are in it) and of the program that simulates, whichever study made it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/batch/journal/journal.h"
#include "experiments/batch/journal/sqlite.h"

namespace firn {

class RunCache {
 public:
  // Opens or makes the file; several processes of one machine may use it at once. Throws InputError
  // when that is not possible.
  // `study`: identity of the study whose runs are added.
  explicit RunCache(const std::string& file, const std::string& study = "");

  std::optional<JobResult> find(const std::string& key);
  // Keeps an outcome. That of a run which was cut short gives way to any later one.
  void add(const PlannedRun& run, const JobResult& result);

  // Parameters (RunLabel::parameters) and seed of a run.
  struct Known {
    std::string parameters;
    std::uint64_t seed = 0;
  };
  // Those of the runs that other studies added with this program, in the order in which they came.
  std::vector<Known> of_other_studies(const std::string& program);

 private:
  std::string study_;
  Database db_;
};

}  // namespace firn
