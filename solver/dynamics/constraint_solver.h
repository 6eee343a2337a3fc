// Linear equations of constraints, of which some may depend on others.
#pragma once

#include <Eigen/Dense>
#include <cmath>

namespace firn {

// Least-squares solution of minimum norm. Rows are scaled first, so that their units have no
// effect.
class ConstraintSolver {
 public:
  explicit ConstraintSolver(const Eigen::MatrixXd& matrix) {
    // Rows along which nothing can move contain only rounding errors.
    const double least =
        kDependent * (matrix.rows() > 0 ? matrix.diagonal().cwiseAbs().maxCoeff() : 0);
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
