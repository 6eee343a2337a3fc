// Runs a solver through the stages of a case: insertion, removal, events, frames, checkpoints.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "experiments/results/checkpoint.h"
#include "experiments/results/contact_statistics_results.h"
#include "experiments/results/recorder.h"
#include "experiments/results/results_writer.h"
#include "experiments/run/interference_check.h"
#include "experiments/run/particle_flow.h"
#include "experiments/run/run.h"
#include "experiments/run/sampler.h"
#include "experiments/run/stage_events.h"
#include "experiments/system/interruption.h"

namespace firn {

// State of a run, in addition to that of the solver, on which the remaining steps depend.
struct DriverState {
  std::uint64_t frames = 0;         // recorded so far
  std::uint64_t loads_cleared = 0;  // step of the last clearing of the boundary loads
  std::uint64_t stage_start = 0;    // step
  std::vector<StageRecord> stages;  // entered so far; the last one is the current stage
  StatisticsRows statistics;
};

// The case of a results file. Throws InputError unless its hash is that of the recorded run.
// `what`: the refused action in the message, "resumed".
Case case_of(const Recording& recording, const char* what);

// Callbacks of an observer. Each may be empty.
struct RunObserver {
  // Called with the state of each step, before the next one. False ends the simulation.
  std::function<bool(const Solver&, bool last)> step;
  // Called with each frame: its number and its row (see frame_row()).
  std::function<void(std::uint64_t frame, const std::vector<double>& row)> frame;
  double end_time_limit = 0;  // s, reported as progress; 0: the case's duration
};

class Driver {
 public:
  // `c` must come from read_case(), which checks it, and must outlive the driver. The recorder's
  // file must be new and have its header. nullptr: nothing is recorded.
  Driver(const Case& c, const RunOptions& options, Recorder* recorder, RunObserver observer = {});

  // Continues from the newest valid checkpoint of the recorder's file and truncates the frames
  // after it. Throws InputError without a checkpoint, and WriteError.
  void restore();
  // Continues from a state of a checkpoint or a saved state. Throws RunError for bytes of another
  // version or case; the driver must not be used afterwards.
  void restore(const std::vector<std::byte>& payload);
  std::uint64_t steps() const { return solver_.steps(); }

  // Runs until the end of the case, an interruption or a failure. Afterwards the file is complete
  // and states how the run ended. If concluded() is false, the file could not be written, and only
  // the copy of the last checkpoint is valid. Throws InputError for a fill that does not fit.
  RunSummary run();
  // Files to remove if the run ends before its first checkpoint.
  void set_unsaved(std::span<interruption::Temporary> files) { unsaved_ = files; }
  bool concluded() const { return concluded_; }
  // What is saved after a write error and how to continue: "the state at t = 0.35 s is safe in
  // ...".
  std::string recovery_hint(const WriteError& e) const;

 private:
  using Clock = std::chrono::steady_clock;

  std::string simulate();  // returns what ended the run; empty: an interruption
  void watch();
  const Stage& stage() const;  // the current one, or the first before the start
  ParticleFlow::CurrentStage stage_now() const;
  void enter_stage(std::size_t number);
  void end_stage(const std::string& by);
  void record_frame();
  void record_sample();     // at the end of an interval
  bool observe(bool last);  // false: the observer ends the simulation
  void save();
  void advise();
  void save_state();
  void write_statistics(bool at_end);
  void write_samples();
  void report();
  void finalize_results(const std::string& status);
  void write_progress(hdf5::File& file);
  std::vector<std::byte> pack() const;
  void unpack(const std::vector<std::byte>& payload);

  double now() const { return solver_.time(); }

  const Case& case_;
  const RunOptions& options_;
  Recorder* recorder_;
  RunObserver observer_;
  std::span<interruption::Temporary> unsaved_;
  std::shared_ptr<const interruption::Advice> advice_;
  Solver solver_;
  const std::vector<Stage> stages_;
  ParticleFlow particle_flow_;
  StageEvents watch_;
  InterferenceMonitor interference_;
  Sampler sampler_;
  std::uint64_t frame_steps_ = 1;
  std::uint64_t interference_steps_ = 1;
  std::uint64_t state_steps_ = 0;  // interval of saved states; 0: none are saved
  std::uint64_t last_step_ = 0;    // of the case
  DriverState state_;
  bool resumed_ = false, save_wanted_ = true, concluded_ = false;
  std::optional<double> safe_time_;  // s, of the checkpoint in the copy
  std::uint64_t checkpoints_ = 0;
  double wall_before_ = 0;  // s, of earlier sessions
  Clock::time_point started_ = Clock::now(), saved_ = started_, reported_ = started_;
};

}  // namespace firn
