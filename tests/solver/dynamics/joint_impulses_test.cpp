// Impulses within bounds on the coordinates of a mechanism, and along directions.
#include "solver/dynamics/joint_impulses.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace firn {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kCoordinates = 4;
constexpr double kConverged = 1e-14;  // m/s or rad/s

MatrixXd any_matrix(std::mt19937& random) {
  std::uniform_real_distribution<double> any(-1, 1);
  return MatrixXd::NullaryExpr(kCoordinates, kCoordinates, [&] { return any(random); });
}

// Symmetric, with eigenvalues from 1 on.
MatrixXd any_mobility(std::mt19937& random) {
  const MatrixXd a = any_matrix(random);
  return MatrixXd::Identity(kCoordinates, kCoordinates) + a * a.transpose() / kCoordinates;
}

using Bounds = std::vector<std::vector<BoundedImpulse>>;

TEST(JointImpulses, ADirectionAlongACoordinateActsAsTheCoordinate) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> positive(0.01, 2);
  for (int member = 0; member < 100; ++member) {
    const MatrixXd mobility = any_mobility(random);
    const VectorXd start = 2 * any_matrix(random).col(0);
    const double limit = positive(random), other = positive(random);
    double given[2] = {0, 0};
    Bounds bounds(kCoordinates), both(kCoordinates);
    bounds[0] = both[0] = {{0.1, other, -other, nullptr}};
    both[2] = {{0, limit, -limit, &given[0]}};
    const DirectedImpulse directed{VectorXd::Unit(kCoordinates, 2), {0, limit, -limit, &given[1]}};
    JointImpulses a(both, {}, mobility, mobility), b(bounds, {directed}, mobility, mobility);
    VectorXd rates_a = start, rates_b = start;
    a.apply(rates_a, kConverged);
    b.apply(rates_b, kConverged);
    a.share();
    b.share();
    EXPECT_LT((rates_a - rates_b).norm(), 1e-12);
    EXPECT_LT((a.impulses() - b.impulses()).norm(), 1e-12);
    EXPECT_NEAR(given[0], given[1], 1e-12);
  }
}

// Each impulse either stops its rate or opposes it at the limit. Together they change the rates.
TEST(JointImpulses, FrictionAlongRandomDirectionsStopsOrOpposesTheirRates) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> positive(0.01, 2);
  int stopped = 0, sliding = 0;
  for (int member = 0; member < 200; ++member) {
    const MatrixXd mobility = any_mobility(random);
    const MatrixXd directions =
        MatrixXd::Identity(kCoordinates, kCoordinates) + 0.3 * any_matrix(random);
    const VectorXd start = 2 * any_matrix(random).col(0);
    constexpr int kDirections = 3;
    double given[kDirections] = {}, limit[kDirections] = {};
    std::vector<DirectedImpulse> directed;
    for (int k = 0; k < kDirections; ++k) {
      limit[k] = positive(random);
      directed.push_back({directions.col(k), {0, limit[k], -limit[k], &given[k]}});
    }
    JointImpulses impulses(Bounds(kCoordinates), directed, mobility, mobility);
    VectorXd rates = start, sum = VectorXd::Zero(kCoordinates);
    impulses.apply(rates, kConverged);
    impulses.share();
    for (int k = 0; k < kDirections; ++k) {
      const double rate = directions.col(k).dot(rates);
      sum += directions.col(k) * given[k];
      EXPECT_LE(std::abs(given[k]), limit[k] * (1 + 1e-12));
      const bool is_stopped = std::abs(given[k]) < limit[k] * (1 - 1e-9);
      (is_stopped ? stopped : sliding) += 1;
      if (is_stopped) {
        EXPECT_NEAR(rate, 0, 1e-9);
      } else {
        EXPECT_LE(given[k] * rate, 1e-9);
      }
    }
    EXPECT_LT((impulses.impulses() - sum).norm(), 1e-12);
    EXPECT_LT((start + mobility * sum - rates).norm(), 1e-9);
  }
  EXPECT_GT(stopped, 50);
  EXPECT_GT(sliding, 50);
}

// A motor without a limit works against friction along the same coordinate. A sweep gives both as
// much as brings a unit mass from rest to the speed of the motor. Two impulses without limits never
// agree.
TEST(JointImpulses, ReturnWhetherTheyHaveConverged) {
  const MatrixXd mobility = MatrixXd::Identity(kCoordinates, kCoordinates);
  constexpr double kUnlimited = std::numeric_limits<double>::infinity();
  for (const double friction : {0.5, 50.0, 5e3, 5e6, kUnlimited}) {
    Bounds bounds(kCoordinates);
    bounds[1] = {{1, kUnlimited, -kUnlimited, nullptr}};
    double given = 0;
    const VectorXd along = VectorXd::Unit(kCoordinates, 1);
    const DirectedImpulse directed{along, {0, friction, -friction, &given}};
    JointImpulses impulses(bounds, {directed}, mobility, mobility);
    VectorXd rates = VectorXd::Zero(kCoordinates);
    const bool converged = impulses.apply(rates, kConverged);
    impulses.share();
    EXPECT_EQ(converged, friction < kUnlimited) << friction;
    EXPECT_EQ(rates, along);
    if (converged) {
      EXPECT_NEAR(given, -friction, 1e-12 * friction);
      EXPECT_NEAR(impulses.impulses()[1], 1, 1e-12 * friction);
    } else {
      EXPECT_GT(given, -friction);
    }
  }
}

TEST(JointImpulses, ADirectionThatTheCouplingsHoldHasNone) {
  std::mt19937 random(9);
  for (int member = 0; member < 20; ++member) {
    const MatrixXd free = any_mobility(random);
    const VectorXd held = any_matrix(random).col(0), response = free * held;
    const MatrixXd tied = free - response * response.transpose() / held.dot(response);
    double given = 0;
    JointImpulses impulses(Bounds(kCoordinates), {{held, {0, 1, -1, &given}}}, tied, free);
    VectorXd rates = tied * any_matrix(random).col(0);
    const VectorXd before = rates;
    impulses.apply(rates, kConverged);
    impulses.share();
    EXPECT_EQ(given, 0);
    EXPECT_EQ(rates, before);
  }
}

}  // namespace
}  // namespace firn
