// State of a running study, validation or sweep, read from its folder without changing it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/batch/journal/journal.h"

namespace firn {

// An estimate of a parameter from the runs so far: value and 95 % interval.
struct ParameterEstimate {
  std::string name, unit;
  double value = 0, low = 0, high = 0;
};

// A measured value that a study fits.
struct FittedTarget {
  std::string response;
  double value = 0;  // in the unit of the response
};

// Time until `left` runs have ended, with `side_by_side` concurrent runs of the mean wall time
// `mean_wall`, all in s. NaN: unknown.
double time_left(double mean_wall, int left, int side_by_side);

struct BatchState {
  bool at_work = false;                 // a process has the lock of the folder
  std::string command;                  // "calibrate", "validate" or "sweep"; empty: not recorded
  int most_runs = 0;                    // largest number of planned runs; 0: not recorded
  int jobs = 0;                         // concurrent simulations; 0: unknown
  std::vector<ParameterEstimate> best;  // after the latest fit of a study
  std::vector<FittedTarget> targets;    // of a study, after its first fit
  std::vector<std::string> determined;  // identifiable combinations of parameters, as text
  std::vector<JournalRun> runs;         // in the order of planning, at most 100 000

  int count(const std::string& status) const;
  int ended() const;         // number of ended runs, with any outcome
  double mean_wall() const;  // s, of the ended runs that were simulated; NaN: none
  double time_left() const;  // s, for `most_runs`; NaN: not known
};

// True if a process has the lock of the folder.
bool is_at_work(const std::string& folder);

// Nothing for a folder without a journal. Throws InputError for a journal that is damaged or of
// another version.
std::optional<BatchState> read_batch_state(const std::string& folder);

// The JSON text of the row "progress" of a journal.
std::string progress_text(const std::string& command, int most_runs, int jobs,
                          const std::string& knowledge);

}  // namespace firn
