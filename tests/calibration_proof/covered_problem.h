// Problems of a text file (problems.toml): formulas in place of experiments, with their truths
// known.
#pragma once

#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "calibrate/study/parameters.h"
#include "tests/calibration_proof/formula.h"

namespace firn::proof {

// A response with its own scatter: normal noise, and a shift in some of the runs. Runs of low
// fidelity have the bias in addition.
struct CoveredResponse {
  std::string name;
  double uncertainty = 0;
  Formula value, noise, shift, shift_share, low_fidelity_bias;
  double mean(const std::vector<double>& v) const { return value(v) + shift(v) * shift_share(v); }
  double run(const std::vector<double>& v, std::mt19937_64& random) const;
};

struct CoveredProblem {
  std::string name;
  std::vector<Parameter> parameters;
  std::vector<CoveredResponse> responses;
  std::vector<std::string> truths;  // "prior", "border", "corner"
  double low_fidelity_cost = 0;     // of a run, where one of high fidelity costs 1; 0: none
  std::string definition;           // parameters, responses and cost as text; defaults are left out
};

// Throws InputError, also for two problems of one name.
std::vector<CoveredProblem> read_covered_problems(const std::string& file);
// A true set of parameters (unit cube): "prior" anywhere, "border" on one border, or "corner".
Eigen::VectorXd draw_truth(const CoveredProblem& problem, const std::string& where,
                           std::mt19937_64& random);
// In the parameters' units.
std::vector<double> values_at(const CoveredProblem& problem, const Eigen::VectorXd& u);
// results.json of a study of so many runs, with parameters p0, p1, ... and the truth as a set to
// compare.
nlohmann::json solve_covered(const CoveredProblem& problem, const std::vector<double>& truth,
                             const std::vector<double>& target, int runs, int seed);

}  // namespace firn::proof
