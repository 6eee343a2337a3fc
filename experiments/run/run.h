// Simulation of a case with a results file. Only run(), resume() and replay() (replay.h) simulate.
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
  double time = 0;            // s, simulated
  double end_time_limit = 0;  // s, the case's duration
  std::string stage;          // name of the current stage
  double wall = 0;            // s, wall time so far
  // Particles in the simulation, pending, and removed.
  std::size_t present = 0, waiting = 0, left = 0;
  struct Passed {
    std::string sensor;
    std::size_t count = 0;  // particles that have been in the sensor
  };
  std::vector<Passed> passed;  // [sensors]
};
// "harvest, 64 particles, 256 to come, 12 through container". Sensors without particles are
// omitted.
std::string stage_text(const Progress& progress);

struct RunOptions {
  std::string results_file;  // HDF5; always written
  int threads = 1;
  double checkpoint_every = 60;  // s of wall time; also on interruption and at the end of a stage
  std::function<void(const Progress&)>
      progress;  // about five times a second, at the start and at the end
  // Called once, when the input has passed all checks and the results file exists.
  std::function<void()> started;
  const std::atomic<bool>* interrupt = nullptr;  // set from a signal handler: save and stop
  // Called with the state of each step in the form in which frames record it: after insertion,
  // removal and change of stage, before the next step. `last`: no step follows.
  std::function<void(const Solver&, bool last)> each_step;
};

struct RunSummary {
  RunStatus status = RunStatus::failed;
  std::string reason;                // one sentence; of a finished run: what ended it
  bool write_failed = false;         // `reason` is a WriteError and names what is saved
  std::string renamed_earlier_file;  // new name of an earlier results file; empty: none
  std::vector<Response> responses;   // measured from the results file
  double simulated = 0;              // s
  double wall = 0;                   // s, this session
  std::uint64_t steps = 0;
  Energy energy;
  Diagnostics diagnostics;
  std::vector<PhaseTime> profile;
  // An interruption of the program while the summary exists names the results file.
  std::shared_ptr<const interruption::Advice> advice;
};

// Simulates the case from its start. read_case() has checked the case. Throws InputError for a case
// that cannot be set up. A simulation that fails gives a summary with status failed, which the
// results file records if it can be written. An existing results file is renamed (RUN.h5 to
// RUN.1.h5).
RunSummary run(const Case& c, const RunOptions& options);

// Continues from the last checkpoint in a results file, with the bits of an uninterrupted run. The
// file of a finished run is not changed; its responses are returned. After any failure, the run can
// be resumed from the last checkpoint. `known`: the case of the file, if the caller has read it;
// null: it is read here. Throws InputError for a file without a run of a case.
RunSummary resume(const std::string& results_file, const RunOptions& options,
                  const Case* known = nullptr);

}  // namespace firn
