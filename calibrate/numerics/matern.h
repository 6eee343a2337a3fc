// The kernel of the Gaussian processes of surrogates.
#pragma once

#include <Eigen/Dense>
#include <cmath>

namespace firn {

// Matern 5/2 correlation as a function of the scaled distance, and its derivative over r^2 / 2.
inline double matern(double r) {
  const double a = std::sqrt(5.0) * r;
  return (1 + a + a * a / 3) * std::exp(-a);
}
inline double matern_slope(double r) {
  const double a = std::sqrt(5.0) * r;
  return -5.0 / 3 * (1 + a) * std::exp(-a);
}

// Length of each row of `apart` with its columns in units of `lengths`.
inline Eigen::ArrayXd scaled_norms(const Eigen::MatrixXd& apart, const Eigen::VectorXd& lengths) {
  return (apart * lengths.cwiseInverse().asDiagonal()).rowwise().norm();
}

}  // namespace firn
