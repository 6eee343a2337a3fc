// State of a running study, validation or sweep, read from its folder without changing it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/batch/batch_progress_record.h"
#include "experiments/batch/journal/journal.h"

namespace firn {

// Time until `left` runs have ended, with `side_by_side` concurrent runs of the mean wall time
// `mean_wall`, all in s. NaN: unknown.
double time_left(double mean_wall, int left, int side_by_side);

struct BatchState {
  bool at_work = false;          // a process has the lock of the folder
  BatchProgressRecord progress;  // empty: not recorded
  std::vector<JournalRun> runs;  // in the order of planning, at most 100 000

  int count(const std::string& status) const;
  int ended() const;         // number of ended runs, with any outcome
  double mean_wall() const;  // s, of the ended runs that were simulated; NaN: none
  double time_left() const;  // s, for all planned runs; NaN: not known
};

// True if a process has the lock of the folder.
bool is_at_work(const std::string& folder);

// Nothing for a folder without a journal. Throws InputError for a journal that is damaged or of
// another version.
std::optional<BatchState> read_batch_state(const std::string& folder);

}  // namespace firn
