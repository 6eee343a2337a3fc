#include "firn/math.h"

#include <cmath>

namespace firn {

Quat shortest_rotation(const Vec3& from, const Vec3& to) {
  const Vec3 a = from.normalized(), b = to.normalized();
  const double cosine = a.dot(b);
  if (cosine < -1 + 1e-12) {  // half a turn about any axis across
    const Vec3 axis = a.unitOrthogonal();
    return {0, axis.x(), axis.y(), axis.z()};
  }
  const double twice = std::sqrt(2 * (1 + cosine));  // 2 cos of half the angle
  const Vec3 v = a.cross(b) / twice;
  return {twice / 2, v.x(), v.y(), v.z()};
}

SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& matrix) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrix);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& matrix) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix, Eigen::EigenvaluesOnly)
      .eigenvalues();
}

}  // namespace firn
