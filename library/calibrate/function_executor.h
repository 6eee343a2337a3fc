// Carries out the runs of a study with a function of the caller. Not installed.
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "experiments/batch/execution/executor.h"
#include "firn/calibrate/calibrate.h"

namespace firn::calibration {

class FunctionExecutor : public Executor {
 public:
  FunctionExecutor(const Simulator& simulator, const Options& options)
      : simulator_(simulator), options_(options) {}

  // One line for each parameter and the seed, behind the version of the simulator.
  ResolvedCase resolve(const std::string& case_file, const std::vector<Override>& overrides,
                       const MaterialRequest& materials) override;
  void run(const std::vector<Job>& jobs, const JobEvents& events) override;

  const std::atomic<bool>& stopped() const { return stop_; }

 private:
  JobResult simulate(const Job& job) const;
  void run_here(const std::vector<Job>& jobs, const JobEvents& events);
  void run_on_threads(const std::vector<Job>& jobs, const JobEvents& events);
  bool should_continue();

  const Simulator& simulator_;
  const Options& options_;
  std::atomic<bool> stop_ = false;
};

}  // namespace firn::calibration
