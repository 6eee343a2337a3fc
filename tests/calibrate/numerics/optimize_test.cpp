// The two optimisers against problems with known answers.
#include "calibrate/numerics/optimize.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace firn {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// A problem of the NIST Statistical Reference Datasets, nonlinear regression.
struct NistProblem {
  std::vector<double> x, y;
  // Model and its derivatives with respect to the parameters.
  std::function<double(double x, const VectorXd& b, VectorXd& gradient)> model;

  LeastSquaresProblem problem() const {
    LeastSquaresProblem p;
    p.residuals = static_cast<int>(x.size());
    p.evaluate = [this](const VectorXd& b, VectorXd& r, MatrixXd* jacobian) {
      VectorXd gradient(b.size());
      for (int i = 0; i < r.size(); ++i) {
        const auto k = static_cast<std::size_t>(i);
        r[i] = model(x[k], b, gradient) - y[k];
        if (jacobian != nullptr) jacobian->row(i) = gradient.transpose();
      }
      return true;
    };
    return p;
  }
};

void expect_certified(const NistProblem& data, const VectorXd& start, const VectorXd& certified,
                      const VectorXd& certified_sd, double certified_squares) {
  const LeastSquaresProblem problem = data.problem();
  EXPECT_LT(jacobian_error(problem, start, 1e-2 * start.cwiseAbs().minCoeff()), 1e-6);
  const LeastSquaresFit fit = least_squares(problem, start);
  EXPECT_TRUE(fit.converged) << fit.message;
  EXPECT_NEAR(fit.sum_of_squares / certified_squares, 1, 1e-8);
  const double freedom = static_cast<double>(data.x.size()) - static_cast<double>(start.size());
  const MatrixXd covariance =
      (fit.jacobian.transpose() * fit.jacobian).inverse() * fit.sum_of_squares / freedom;
  for (int i = 0; i < certified.size(); ++i) {
    EXPECT_NEAR(fit.x[i] / certified[i], 1, 1e-6);
    EXPECT_NEAR(std::sqrt(covariance(i, i)) / certified_sd[i], 1, 1e-5);
  }
}

TEST(LeastSquares, Misra1aFromTheFarStart) {
  const NistProblem misra1a{{77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3,
                             536.8, 593.1, 689.1, 760.0},
                            {10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05,
                             61.01, 66.40, 75.47, 81.78},
                            [](double x, const VectorXd& b, VectorXd& g) {
                              const double e = std::exp(-b[1] * x);
                              g << 1 - e, b[0] * x * e;
                              return b[0] * (1 - e);
                            }};
  expect_certified(misra1a, Eigen::Vector2d(500, 1e-4),
                   Eigen::Vector2d(2.3894212918e+02, 5.5015643181e-04),
                   Eigen::Vector2d(2.7070075241, 7.2668688436e-06), 1.2455138894e-01);
}

TEST(LeastSquares, DanWood) {
  const NistProblem dan_wood{{1.309, 1.471, 1.490, 1.565, 1.611, 1.680},
                             {2.138, 3.421, 3.597, 4.340, 4.882, 5.660},
                             [](double x, const VectorXd& b, VectorXd& g) {
                               const double p = std::pow(x, b[1]);
                               g << p, b[0] * p * std::log(x);
                               return b[0] * p;
                             }};
  EXPECT_LT(jacobian_error(dan_wood.problem(), Eigen::Vector2d(1, 5)), 1e-6);
  expect_certified(dan_wood, Eigen::Vector2d(1, 5), Eigen::Vector2d(7.6886226176e-01, 3.8604055871),
                   Eigen::Vector2d(1.8281973860e-02, 5.1726610913e-02), 4.3173084083e-03);
}

TEST(LeastSquares, StaysWithinItsBounds) {
  LeastSquaresProblem p;  // minimum of (x - 3)^2 within [0, 1]
  p.residuals = 1;
  p.lower = VectorXd::Zero(1);
  p.upper = VectorXd::Ones(1);
  p.evaluate = [](const VectorXd& x, VectorXd& r, MatrixXd* jacobian) {
    r[0] = x[0] - 3;
    if (jacobian != nullptr) (*jacobian)(0, 0) = 1;
    return true;
  };
  const LeastSquaresFit fit = least_squares(p, VectorXd::Constant(1, 0.5));
  EXPECT_DOUBLE_EQ(fit.x[0], 1);
  EXPECT_DOUBLE_EQ(fit.sum_of_squares, 4);
}

double branin(double x, double y) {
  const double t = y - 5.1 / (4 * M_PI * M_PI) * x * x + 5 / M_PI * x - 6;
  return t * t + 10 * (1 - 1 / (8 * M_PI)) * std::cos(x) + 10;
}

TEST(Minimize, Branin) {
  const Minimum m = minimize([](const VectorXd& x) { return branin(x[0], x[1]); },
                             Eigen::Vector2d(-5, 0), Eigen::Vector2d(10, 15), 400);
  EXPECT_NEAR(m.value, 0.39788735772973816, 1e-8);
  EXPECT_EQ(m.non_finite, 0);
}

TEST(Minimize, ForresterInOneDimension) {
  const auto f = [](const VectorXd& x) {
    return std::pow(6 * x[0] - 2, 2) * std::sin(12 * x[0] - 4);
  };
  const Minimum m = minimize(f, VectorXd::Zero(1), VectorXd::Ones(1), 200);
  EXPECT_NEAR(m.x[0], 0.757249, 1e-5);
  EXPECT_NEAR(m.value, -6.020740, 1e-6);
}

TEST(Minimize, ValuesThatAreNotNumbersDoNotStopIt) {
  // Nothing is known to the left of x = 2, where one of Branin's three minima lies.
  const auto f = [](const VectorXd& x) {
    return x[0] < 2 ? std::numeric_limits<double>::quiet_NaN() : branin(x[0], x[1]);
  };
  const Minimum m = minimize(f, Eigen::Vector2d(-5, 0), Eigen::Vector2d(10, 15), 600);
  EXPECT_GT(m.non_finite, 0);
  EXPECT_NEAR(m.value, 0.39788735772973816, 1e-6);
}

TEST(Minimize, NeverLeavesTheBox) {
  const Eigen::Vector2d lower(0.1, 0.3), upper(0.7, 0.9);
  bool inside = true;
  const auto f = [&](const VectorXd& x) {
    inside = inside && (x.array() >= lower.array()).all() && (x.array() <= upper.array()).all();
    return -x.sum();
  };
  const Minimum m = minimize(f, lower, upper, 200);
  EXPECT_TRUE(inside);
  EXPECT_NEAR(m.value, -1.6, 1e-9);
}

}  // namespace
}  // namespace firn
