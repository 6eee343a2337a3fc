// Searches for the design that maximizes or minimizes the mean of a response over seeds and
// material, where the probabilities of given events stay below their limits. docs/optimization.md
// describes the method.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calibrate/inference/response_model.h"
#include "calibrate/optimization/event_probability.h"
#include "calibrate/optimization/optimization_study.h"
#include "experiments/batch/batch_folder.h"

namespace firn {

// What the models predict of a design.
struct DesignPrediction {
  double mean = 0, sd = 0;            // of the mean objective
  std::vector<double> probabilities;  // of the events, by limit
  double kept = 1;                    // probability that all limits are kept
};

// Models of the objective and of the events, fitted to the runs so far.
class DesignModels {
 public:
  DesignModels(const OptimizationStudy& o, ResponseModel objective,
               const std::vector<Point>& points);

  DesignPrediction predict(const Eigen::VectorXd& u) const;
  // Expected improvement of the mean over `incumbent`, times the probability that all limits are
  // kept (Gardner and others 2014, Bayesian optimization with inequality constraints). Without an
  // incumbent, that probability.
  double merit(const Eigen::VectorXd& u, std::optional<double> incumbent) const;
  // These models as if a design had been simulated there and had its predicted mean.
  void believe(const Eigen::VectorXd& u);

 private:
  const OptimizationStudy& o_;
  ResponseModel objective_;
  Surrogate surrogate_;
  std::vector<EventProbability> events_;  // by limit
};

struct EventRate {
  int events = 0, runs = 0;
  Interval interval_95;
};

// A design with what its own runs gave.
struct TriedDesign {
  std::string name;
  std::vector<double> values;  // in order of Study::parameters
  int runs = 0, finished = 0;
  Sample objective;
  std::vector<EventRate> events;              // by limit
  std::optional<DesignPrediction> predicted;  // by the final models
};

// Mean objective of the best design minus that of a compared one, over the seeds that both have.
struct DesignDifference {
  double mean = 0, low = 0, high = 0;  // 95 % interval by Student's distribution
  int pairs = 0;
};

// Mean prediction along one parameter through the best design.
struct DesignSlice {
  std::vector<double> values, mean, sd, kept;
};

enum class OptimizationVerdict {
  recommended,    // all limits are kept with the confidence asked for, confirmation included
  not_shown,      // the best design is likely to keep them, but not with that confidence
  none_feasible,  // no design within the ranges is likely to keep them
  too_few_runs,
  interrupted
};
const char* to_string(OptimizationVerdict verdict);  // as results.json has it

struct OptimizationResult {
  OptimizationStudy optimization;
  std::string objective_unit;
  std::vector<TriedDesign> designs;     // of the search
  std::optional<TriedDesign> best;      // by fresh seeds
  std::vector<TriedDesign> compared;    // by the same seeds
  std::vector<DesignDifference> gains;  // by compared design
  std::vector<DesignSlice> slices;      // by parameter
  OptimizationVerdict verdict = OptimizationVerdict::too_few_runs;
  std::string headline;  // one sentence
  std::string directory;
  int runs = 0, not_finished = 0;
};

struct OptimizationOptions : BatchOptions {
  std::string file;  // TOML
};

// Runs or resumes an optimization and writes runs.csv and results.json to the directory. Throws
// InputError for a wrong file, a directory with other content, and a response that the case does
// not have.
OptimizationResult optimize_design(const OptimizationOptions& options);

std::string render_table(const OptimizationResult& result);  // as text
std::string render_json(const OptimizationResult& result);

}  // namespace firn
