// How much of the variation of a response over the ranges is whose doing.
#pragma once

#include <Eigen/Dense>
#include <functional>

namespace firn {

// Variance-based sensitivity (Sobol 1993) of f over the unit cube.
struct SobolIndices {
  Eigen::VectorXd first;  // [parameters], share of the variance by each parameter alone
  Eigen::VectorXd total;  // [parameters], its interactions with others included
  double variance = 0;    // of f
  // Of 95 %, by resampling the evaluations (bootstrap): low and high, [parameters, 2].
  Eigen::MatrixX2d first_interval, total_interval;
};

// Estimators of Saltelli (2010) for the first order and Jansen (1999) for the total, from
// (parameters + 2) * `samples` evaluations. Deterministic. The intervals are those of the
// estimators, for f as it is.
SobolIndices sobol_indices(const std::function<double(const Eigen::VectorXd&)>& f, int parameters,
                           int samples);

}  // namespace firn
