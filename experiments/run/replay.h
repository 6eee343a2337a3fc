// Simulation without a results file, for an observer: of a case, or of a recorded run. The latter
// is compared with the recording bit by bit.
#pragma once

#include "experiments/run/run.h"

namespace firn {

struct ReplayOptions {
  int threads = 1;
  std::uint64_t from_step = 0;  // first step that is observed
  double end_time_limit = 0;    // s, reported as progress; 0: the case's duration
  std::function<void(const Progress&)> progress;
  const std::atomic<bool>* interrupt = nullptr;  // set from a signal handler: stop
  // As RunOptions::each_step, from step `from_step` on. False ends the replay.
  std::function<bool(const Solver&, bool last)> observe;
};

struct Replay {
  bool interrupted = false;
  std::string reason;            // one sentence: how it ended
  double simulated = 0;          // s, time reached
  std::uint64_t began_at = 0;    // first step; 0: the start of the run
  std::size_t frames_equal = 0;  // recorded frames that are bit-identical
  double verified_until = 0;     // s, time of the last of them
};

// Simulates a case for an observer, without a results file. Throws as run() does, and RunError when
// the simulation fails.
Replay replay(const Case& c, const ReplayOptions& options);

// Repeats the run of a results file, from the latest saved state not after `from_step` to the first
// recorded frame after the last observed state. Throws RunError that names the first number that
// differs from a recorded frame (other version of the program or other machine), and InputError for
// a file without a run. The file is only read.
Replay replay(const std::string& results_file, const ReplayOptions& options);

}  // namespace firn
