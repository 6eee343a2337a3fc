// Outcomes that studies share: a run is found by the hash of its complete case text (parameters,
// seed and meshes are in it) and of the program that simulates, whichever study made it.
#pragma once

#include <optional>
#include <string>

#include "experiments/batch/journal.h"
#include "experiments/batch/sqlite.h"

namespace firn {

class RunStore {
 public:
  // Opens or makes the file; several processes of one machine may use it at once. Throws InputError
  // when that is not possible.
  explicit RunStore(const std::string& file);

  std::optional<JobResult> find(const std::string& key);
  // Keeps an outcome. That of a run which was cut short gives way to any later one.
  void add(const PlannedRun& run, const JobResult& result);

 private:
  Database db_;
};

}  // namespace firn
