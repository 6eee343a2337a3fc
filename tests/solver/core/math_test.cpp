// Shortest rotations and eigenvalues of symmetric matrices against their definitions.
#include "firn/math.h"

#include <gtest/gtest.h>

#include "tests/solver/collision/brute_force_distance.h"

namespace firn {
namespace {

TEST(Math, ShortestRotationTakesOneDirectionToTheOther) {
  testing::Random random(5);
  for (int k = 0; k < 1000; ++k) {
    const Vec3 from = random.direction();
    Vec3 to = random.direction();
    if (k % 4 == 1) to = -3 * from;                               // half a turn
    if (k % 4 == 2) to = -from + 1e-7 * random.direction();       // nearly
    if (k % 4 == 3) to = 0.1 * from + 1e-9 * random.direction();  // hardly any turn
    const Quat q = shortest_rotation(from, to);
    EXPECT_NEAR(q.norm(), 1, 1e-9);
    EXPECT_LT((q.normalized() * from.normalized() - to.normalized()).norm(), 1e-6);
    const double angle = std::atan2(from.cross(to).norm(), from.dot(to));
    EXPECT_NEAR(2 * std::acos(std::min(1.0, std::abs(q.w()))), angle, 1e-6);
  }
}

TEST(Math, SymmetricEigenvaluesMeetTheirDefinition) {
  testing::Random random(6);
  for (int n = 1; n <= 12; ++n) {
    const Eigen::MatrixXd any =
        Eigen::MatrixXd::NullaryExpr(n, n, [&] { return random.uniform(-2, 2); });
    const Eigen::MatrixXd m = any + any.transpose();
    const SymmetricEigen e = symmetric_eigen(m);
    EXPECT_LT((m * e.vectors - e.vectors * e.values.asDiagonal()).norm(), 1e-12 * n * n);
    EXPECT_LT((e.vectors.transpose() * e.vectors - Eigen::MatrixXd::Identity(n, n)).norm(),
              1e-13 * n);
    EXPECT_LT((symmetric_eigenvalues(m) - e.values).norm(), 1e-12 * n);
    for (Eigen::Index i = 1; i < n; ++i) EXPECT_LE(e.values[i - 1], e.values[i]);
  }
}

}  // namespace
}  // namespace firn
