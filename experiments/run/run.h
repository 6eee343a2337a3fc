// run(case, options) -> responses. Only this function and replay() (replay.h) start simulations.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "experiments/case/case.h"
#include "experiments/results/response.h"
#include "experiments/system/interruption.h"
#include "firn/solver.h"

namespace firn {

enum class RunStatus { finished, failed, interrupted };
const char* to_string(RunStatus status);

struct Progress {
  double time = 0;                                 // s, simulated
  double latest_end = 0;                           // s, the case's duration
  std::string stage;                               // name of the stage under way
  double wall = 0;                                 // s, so far
  std::size_t present = 0, waiting = 0, left = 0;  // particles
  struct Passed {
    std::string sensor;
    std::size_t count = 0;
  };
  std::vector<Passed> passed;  // particles that have been in each sensor of the case
};
// "harvest, 64 particles, 256 to come, 12 through container": sensors that no particle has passed
// are omitted.
std::string stage_text(const Progress& progress);

struct RunOptions {
  std::string results_file;  // HDF5; always written
  int threads = 1;
  double checkpoint_every = 60;  // s of wall time; also on interruption and at the end of a stage
  std::function<void(const Progress&)> progress;  // about five times a second, first and last
  const std::atomic<bool>* interrupt = nullptr;   // set from a signal handler: save and stop
  // Called with the state of each step as a frame would hold it: batches placed, outlets and stages
  // done, the next step still to be taken. `last`: no step follows.
  std::function<void(const Solver&, bool last)> each_step;
};

struct RunSummary {
  RunStatus status = RunStatus::failed;
  std::string reason;               // one sentence; for a finished run, what ended it
  bool write_failed = false;        // `reason` is a WriteError and what is safe
  std::string kept_earlier;         // earlier results of the same name are now here; empty: none
  std::vector<Response> responses;  // measured from the recording alone
  double simulated = 0;             // s
  double wall = 0;                  // s, this session
  std::uint64_t steps = 0;
  Energy energy;
  Diagnostics diagnostics;
  std::vector<PhaseTime> profile;
  // Holds while the summary exists: an interruption after the end of the run names the file.
  std::shared_ptr<const interruption::Advice> advice;
};

// Simulates a case from its start. Reading has checked the case (read_case). Throws InputError for
// a case that cannot be set up; a run that goes wrong is a summary with status failed, and its
// results file says so where it can be written. Results that exist already under the same name are
// kept under another one (RUN.h5 becomes RUN.1.h5).
RunSummary run(const Case& c, const RunOptions& options);

// Continues from the last checkpoint in a results file, bit for bit as if it had never stopped. A
// file whose run is finished is left as it is, and its responses are returned. After any failure,
// the run can be resumed from the last checkpoint. `known`: the case of the file, of a caller that
// has read it; null: it is read here.
RunSummary resume(const std::string& results_file, const RunOptions& options,
                  const Case* known = nullptr);

}  // namespace firn
