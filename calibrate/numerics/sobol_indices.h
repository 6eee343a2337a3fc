// Sobol indices: shares of the variance of a response by parameter.
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <functional>

namespace firn {

// Variance-based sensitivity (Sobol 1993) of f over the unit cube.
struct SobolIndices {
  Eigen::VectorXd first;  // [parameters], share of the variance by each parameter alone
  Eigen::VectorXd total;  // [parameters], its interactions with others included
  double variance = 0;    // of f
  // Of 95 %, from the scatter of independent replicates of the estimate: low and high,
  // [parameters, 2]. An end may lie below 0 or above 1.
  Eigen::MatrixX2d first_interval, total_interval;
};

// Estimators of Saltelli (2010) for the first order and Jansen (1999) for the total, from
// (parameters + 2) * `samples` evaluations: eight replicates of randomized Halton points. `samples`
// is at least 16; a remainder of the division by eight is left out. The intervals are those of the
// estimators, for f as it is: Student's, of the ratio of the replicates' means (Cochran, Sampling
// Techniques, section 6.3). Equal seeds give equal results.
SobolIndices sobol_indices(const std::function<double(const Eigen::VectorXd&)>& f, int parameters,
                           int samples, std::uint64_t seed = 20101);

}  // namespace firn
