// Whether the best parameters meet all targets together.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "calibrate/inference/response_model.h"

namespace firn {

// Chi-square of the residuals of all targets at the parameters that meet them best.
struct GoodnessOfFit {
  double chi_square = 0;
  double freedom = 1;       // targets less the parameters' directions that they determine
  double probability = 1;   // of at least this chi-square under the fitted model
  Eigen::VectorXd u;        // minimum, unit cube
  std::vector<double> z;    // residual of each target in standard deviations
  bool acceptable() const;  // the probability is at least 5 %
};

enum class Priors { with, without };

// Finds the minimum from `start` (unit cube). With priors, each prior adds a residual. A parameter
// at a bound of its range takes no degree of freedom: the probability is conditional on the
// parameters that are at their bounds.
GoodnessOfFit goodness_of_fit(const Study& study, const ResponseModels& models,
                              const Eigen::VectorXd& start, Priors priors);

// Probability that chi-square with so many degrees of freedom (> 0) is at least x (>= 0).
double chi_square_tail(double x, double freedom);

}  // namespace firn
