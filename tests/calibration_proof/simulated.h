// Studies whose truth is simulated: parameters are drawn at random and hidden, the shipped solver
// makes the measurement, and the shipped engine is to find them again.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "experiments/batch/execution/executor.h"
#include "experiments/batch/journal/run_cache.h"

namespace firn::proof {

struct SimulatedProblem {
  std::string name;
  std::string case_file;  // relative to the source tree
  struct Unknown {
    std::string name;
    std::vector<std::string> keys;
    double min = 0, max = 0;               // on a logarithmic scale
    std::string unit{};                    // empty: a bare number
    std::string text(double value) const;  // as a case or a study takes it
  };
  std::vector<Unknown> unknowns;
  struct Measured {
    std::string response, unit;
    double reading = 0;  // sd of an error that all repeats share
    double assumed_sd =
        0;  // of a repeat, stated in the file; 0: the file has the repeats themselves
  };
  std::vector<Measured> measured;
  int repeats = 0;               // runs at the truth that make the measurement
  std::vector<Override> limits;  // of the study's runs alone: the truth is simulated without
  std::string budget;            // keys of [budget]
  int fresh = 0;     // runs at the answer that the study has not used, to judge its confirmation
  int at_truth = 0;  // further runs at the truth, to judge the measurement alone
  // All studies begin with the same runs and differ in truth, measurement and refinement.
  bool same_design = false;
};
const std::vector<SimulatedProblem>& simulated_problems();

// How one study went.
struct Verdict {
  std::string verdict;  // of the study
  std::vector<double> truth;
  std::optional<double> hpd_level;  // share of the posterior denser than the truth; nothing: no fit
  int intervals = 0;                // of single parameters that hold the truth
  // (value of the determined combination at the truth - stated value) / stated uncertainty
  std::optional<double> combination_z, strayed_z;  // the latter: over its spread along the valley
  // (confirmed - fresh mean) over both standard errors together; of each target
  std::vector<double> reported_z;
  // Of each target at the truth, against the mean of further runs there, in standard errors of both
  // together: the measured value, and the response that the study fits.
  std::vector<double> measured_z, fitted_z;
  int runs = 0, arched = 0, failed = 0;
  double wall = 0;  // s, of the study's runs
};

// Everything that the studies of one problem share.
class SimulatedStudies {
 public:
  // Runs go to and come from `store`; files below `folder`, results files are not kept.
  SimulatedStudies(const SimulatedProblem& problem, const std::string& folder,
                   const std::string& store, const std::string& program, int jobs, bool plot);
  // Nothing when no measurement comes of the truth: its runs arch or fail.
  std::optional<Verdict> study(int number);

 private:
  using Values = std::vector<double>;
  std::vector<JobResult> runs_at(const Values& values, std::uint64_t first_seed, int count);
  std::vector<Values> repeats_of(const std::vector<JobResult>& runs, int number) const;
  void write_measurements(const std::vector<Values>& repeats) const;
  void judge_at_truth(const std::vector<Values>& repeats, const std::string& results,
                      std::uint64_t first_seed, Verdict& v);
  std::string study_text(const Values& truth, std::uint64_t seed) const;
  Values drawn_truth(int number) const;
  std::optional<std::vector<JobResult>> measured_at(const Values& truth, std::uint64_t first_seed);
  std::string results_of(const std::string& file, int number) const;
  std::vector<double> reported_z(const std::string& results, std::uint64_t first_seed);

  const SimulatedProblem& problem_;
  std::string folder_, store_file_, program_;
  RunCache store_;
  std::unique_ptr<Executor> executor_;
  int jobs_;
  bool plot_;
};

}  // namespace firn::proof
