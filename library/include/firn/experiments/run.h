// Simulates a case in this process and writes its results file.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "firn/experiments/case.h"
#include "firn/experiments/response.h"
#include "firn/solver.h"

namespace firn::experiments {

struct RunOptions {
  std::string results_file;  // HDF5, required; existing results are renamed (RUN.h5 to RUN.1.h5)
  int threads = 1;           // results are the same bits for any number
  double checkpoint_every = 60;  // s of wall time
  // Called with each state that the results file records, before the next step; false stops the run
  // as an interruption does. The solver must not be kept beyond the call. Called on the thread of
  // run(). An exception stops the run as an interruption does, and then leaves run().
  std::function<bool(const Solver&)> on_frame;
  // Called about five times a second with the simulated time (s), on the thread of run(); false
  // stops the run.
  std::function<bool(double time)> on_progress;
  // Set from another thread or a signal handler: the state is saved and the run stops within a
  // step.
  const std::atomic<bool>* interrupt = nullptr;
};

struct RunResult {
  enum class Status { finished, failed, interrupted };
  Status status = Status::failed;
  std::string reason;               // one sentence; of a finished run what ended it
  std::vector<Response> responses;  // of a finished run
  double simulated = 0;             // s
  double wall = 0;                  // s
  std::uint64_t steps = 0;
  Energy energy;  // at the end, J
  Diagnostics diagnostics;
  std::string results_file;

  // Takes current_response_name(name). Throws RunError for one that is not among the responses.
  const Response& response(const std::string& name) const;
};

// Throws InputError for a case that cannot be simulated. A simulation that fails is a result with
// status failed, and its file says so.
RunResult run(const Case& c, const RunOptions& options);

// Continues an interrupted run from its results file, with the bits of an uninterrupted one.
// `options.results_file` is not used.
RunResult resume(const std::string& results_file, const RunOptions& options = {});

}  // namespace firn::experiments
