// One study of a problem of the text file: truth and measurement are drawn, the shipped method
// estimates the parameters, and its result is compared with the truth and with the exact posterior.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tests/calibration_proof/covered_problem.h"

namespace firn::proof {

// What is drawn for a study. The names of problem and place and the index determine the random
// numbers, whatever other studies are carried out.
struct StudyDraw {
  Eigen::VectorXd u;           // truth, unit cube
  std::vector<double> truth;   // in the parameters' units
  std::vector<double> target;  // measured values
  int seed = 1;                // first seed of the runs
};
StudyDraw draw_study(const CoveredProblem& problem, const std::string& where, int index);

// The ideal is the posterior with the exact mean responses.
struct CoverageOutcome {
  std::string verdict;            // of the study
  int cautions = 0;               // limits of the verdict that the report states
  bool ideal_infeasible = false;  // verdict of the same test with the exact responses
  // Share of the posterior that is denser than the truth. Empty: the study has no posterior, and
  // all below but the cost is empty or 0.
  std::optional<double> level;
  double ideal_level = 0;
  double width = 0;  // standard deviation over the ideal's: geometric mean over the parameters
  int parameters = 0;
  int intervals = 0;   // 95 % intervals of parameters that hold the truth
  int determined = 0;  // identifiable combinations
  int far_off = 0;     // of these, off the truth by more than twice the stated uncertainty
  // Error over stated standard error: of the confirmed responses at the answer, and of the response
  // models at the truth.
  std::vector<double> confirmed_z, model_z;
  double cost = 0;  // of the runs, where one of high fidelity costs 1
};

// Runs of a recorded study.
inline constexpr int coverage_runs = 40;

// Carries out a study of so many runs. Deterministic.
CoverageOutcome cover(const CoveredProblem& problem, const std::string& where, int index, int runs);

}  // namespace firn::proof
