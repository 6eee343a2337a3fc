// A simulation without a results file, for observers: of a recorded run, compared with the
// recording bit for bit, or of a case.
#pragma once

#include "experiments/run/run.h"

namespace firn {

struct ReplayOptions {
  int threads = 1;
  std::uint64_t from_step = 0;  // states before it are not observed
  double latest_end = 0;        // s, reported as progress; 0: the case's duration
  std::function<void(const Progress&)> progress;
  const std::atomic<bool>* interrupt = nullptr;  // stop
  // As RunOptions::each_step, from from_step on. False ends the replay.
  std::function<bool(const Solver&, bool last)> observe;
};

struct Replay {
  bool interrupted = false;
  std::string reason;            // one sentence: how it ended
  double simulated = 0;          // s, time reached
  std::uint64_t began_at = 0;    // step; 0: at the start
  std::size_t frames_equal = 0;  // recorded frames that are bit-identical
  double proved_until = 0;       // s, the last of them
};

// Simulates a case for an observer, without a results file. Throws as run() does, and RunError when
// the simulation fails.
Replay replay(const Case& c, const ReplayOptions& options);

// Simulates the run of a results file again, from the newest state in it that is not after
// from_step, and continues to the first recorded frame after the last state observed. Every frame
// is compared with the recorded one: throws RunError naming the first number that differs (another
// version of the program, another machine), and InputError for a file that does not hold a run. The
// file is only read.
Replay replay(const std::string& results_file, const ReplayOptions& options);

}  // namespace firn
