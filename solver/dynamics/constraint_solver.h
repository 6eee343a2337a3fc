// Linear equations of constraints, of which some may depend on others.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace firn {

// Least-squares solution of minimum norm. Rows are scaled first, so that their units have no
// effect.
class ConstraintSolver {
 public:
  // Rows along which nothing can move contain only rounding errors. They are those whose diagonal
  // is not above `rounding`, or is small against the largest one.
  ConstraintSolver(const Eigen::MatrixXd& matrix, double rounding) {
    const double largest = matrix.rows() > 0 ? matrix.diagonal().cwiseAbs().maxCoeff() : 0;
    const double least = std::max(rounding, kDependent * largest);
    scale_ = Eigen::VectorXd::Zero(matrix.rows());
    for (Eigen::Index i = 0; i < matrix.rows(); ++i)
      if (const double d = std::abs(matrix(i, i)); d > least) scale_[i] = 1 / std::sqrt(d);
    factors_.setThreshold(kDependent);
    if (matrix.rows() > 0) factors_.compute(scale_.asDiagonal() * matrix * scale_.asDiagonal());
  }
  Eigen::MatrixXd solve(const Eigen::MatrixXd& right) const {
    if (right.rows() == 0) return right;
    return scale_.asDiagonal() * factors_.solve(Eigen::MatrixXd(scale_.asDiagonal() * right));
  }

 private:
  // Threshold below which rows of couplings are linearly dependent.
  static constexpr double kDependent = 1e-11;
  Eigen::VectorXd scale_;
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> factors_;
};

}  // namespace firn
