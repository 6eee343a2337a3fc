// The sampler, the profiles and the sensitivities against densities and functions in closed form.
#include "calibrate/inference/posterior.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "calibrate/numerics/sobol_indices.h"

namespace firn {
namespace {

using Eigen::VectorXd;

double mean_of(const Posterior& p, const std::function<double(const VectorXd&)>& f) {
  double sum = 0;
  for (std::size_t s = 0; s < p.u.size(); ++s) sum += p.weight[s] * f(p.u[s]);
  return sum;
}

TEST(Posterior, NarrowCorrelatedGaussianInFiveDimensions) {
  // Standard deviations 0.01 and a chain of correlations of 0.9: no box holds it well.
  Eigen::MatrixXd covariance(5, 5);
  for (int i = 0; i < 5; ++i)
    for (int j = 0; j < 5; ++j) covariance(i, j) = 1e-4 * std::pow(0.9, std::abs(i - j));
  const Eigen::MatrixXd inverse = covariance.inverse();
  VectorXd mean(5);
  mean << 0.2, 0.4, 0.5, 0.6, 0.8;
  const Posterior p =
      sample_density([&](const VectorXd& u) { return (u - mean).dot(inverse * (u - mean)); }, 5);
  EXPECT_GT(p.effective_samples, 2000);
  for (int i = 0; i < 5; ++i) {
    const double m = mean_of(p, [&](const VectorXd& u) { return u[i]; });
    EXPECT_NEAR(m, mean[i], 1e-3);
    EXPECT_NEAR(std::sqrt(mean_of(p, [&](const VectorXd& u) { return (u[i] - m) * (u[i] - m); })),
                0.01, 8e-4);
  }
  // 95 % of chi squared with five degrees of freedom.
  EXPECT_NEAR(p.hpd_95_cost, 11.07, 0.5);
}

TEST(Posterior, TwoSeparateAnswersKeepTheirShares) {
  // Two Gaussians of sd 0.02, the left one three times as heavy.
  const auto density = [](const VectorXd& u) {
    const double l = (u - Eigen::Vector2d(0.2, 0.3)).squaredNorm() / (2 * 0.02 * 0.02);
    const double r = (u - Eigen::Vector2d(0.8, 0.6)).squaredNorm() / (2 * 0.02 * 0.02);
    return 0.75 * std::exp(-l) + 0.25 * std::exp(-r);
  };
  const Posterior p = sample_density(
      [&](const VectorXd& u) { return -2 * std::log(std::max(density(u), 1e-300)); }, 2);
  EXPECT_NEAR(mean_of(p, [](const VectorXd& u) { return u[0] < 0.5; }), 0.75, 0.06);
}

TEST(Posterior, FlatStaysUniform) {
  const Posterior p = sample_density([](const VectorXd&) { return 3.0; }, 3);
  EXPECT_NEAR(p.effective_samples, static_cast<double>(p.u.size()), 1e-6);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(mean_of(p, [&](const VectorXd& u) { return u[i]; }), 0.5, 2e-3);
    EXPECT_NEAR(mean_of(p, [&](const VectorXd& u) { return u[i] * u[i]; }), 1.0 / 3, 2e-3);
  }
}

TEST(Posterior, BananaAgainstQuadrature) {
  // u[1] follows a parabola of u[0]: a bent valley.
  const auto cost = [](const VectorXd& u) {
    return std::pow((u[1] - 4 * (u[0] - 0.5) * (u[0] - 0.5)) / 0.02, 2);
  };
  const Posterior p = sample_density(cost, 2);
  double w = 0, x2 = 0, y = 0;
  constexpr int cells = 1500;
  for (int i = 0; i < cells; ++i)
    for (int j = 0; j < cells; ++j) {
      const Eigen::Vector2d u((i + 0.5) / cells, (j + 0.5) / cells);
      const double d = std::exp(-0.5 * cost(u));
      w += d;
      x2 += d * (u[0] - 0.5) * (u[0] - 0.5);
      y += d * u[1];
    }
  EXPECT_NEAR(mean_of(p, [](const VectorXd& u) { return (u[0] - 0.5) * (u[0] - 0.5); }), x2 / w,
              0.05 * x2 / w);
  EXPECT_NEAR(mean_of(p, [](const VectorXd& u) { return u[1]; }), y / w, 0.03 * y / w);
}

// Ishigami and Homma (1990), a = 7, b = 0.1, over [-pi, pi]^3; variances in closed form.
TEST(Sobol, Ishigami) {
  constexpr double a = 7, b = 0.1, pi = M_PI;
  const auto f = [&](const VectorXd& u) {
    const VectorXd x = pi * (2 * u.array() - 1);
    return std::sin(x[0]) + a * std::pow(std::sin(x[1]), 2) +
           b * std::pow(x[2], 4) * std::sin(x[0]);
  };
  const double v1 = 0.5 * std::pow(1 + b * std::pow(pi, 4) / 5, 2), v2 = a * a / 8;
  const double v13 = b * b * std::pow(pi, 8) * (1.0 / 18 - 1.0 / 50), v = v1 + v2 + v13;
  const SobolIndices s = sobol_indices(f, 3, 16384);
  EXPECT_NEAR(s.variance, v, 0.01 * v);
  EXPECT_NEAR(s.first[0], v1 / v, 0.01);
  EXPECT_NEAR(s.first[1], v2 / v, 0.01);
  EXPECT_NEAR(s.first[2], 0, 0.01);
  EXPECT_NEAR(s.total[0], (v1 + v13) / v, 0.01);
  EXPECT_NEAR(s.total[1], v2 / v, 0.01);
  EXPECT_NEAR(s.total[2], v13 / v, 0.01);
}

// Sobol's g-function, six parameters of falling importance.
TEST(Sobol, GFunction) {
  const double a[] = {0, 0.5, 3, 9, 99, 99};
  const auto f = [&](const VectorXd& u) {
    double product = 1;
    for (int i = 0; i < 6; ++i) product *= (std::abs(4 * u[i] - 2) + a[i]) / (1 + a[i]);
    return product;
  };
  double all = 1;
  std::vector<double> part;
  for (const double ai : a) part.push_back(1 / (3 * (1 + ai) * (1 + ai)));
  for (const double v : part) all *= 1 + v;
  const double variance = all - 1;
  const SobolIndices s = sobol_indices(f, 6, 16384);
  for (std::size_t i = 0; i < 6; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    EXPECT_NEAR(s.first[k], part[i] / variance, 0.015) << i;
    EXPECT_NEAR(s.total[k], part[i] * all / (1 + part[i]) / variance, 0.015) << i;
  }
}

}  // namespace
}  // namespace firn
