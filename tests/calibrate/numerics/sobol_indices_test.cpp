// How often the intervals of Sobol indices hold the indices in closed form.
#include "calibrate/numerics/sobol_indices.h"

#include <gtest/gtest.h>

#include <cmath>

#include "calibrate/numerics/experimental_design.h"
#include "tests/support/fake_experiment.h"

namespace firn {
namespace {

using Eigen::Index;
using Eigen::MatrixX2d;
using Eigen::VectorXd;

struct KnownIndices {
  std::function<double(const VectorXd&)> f;
  VectorXd first, total;
};

// Ishigami and Homma (1990), a = 7, b = 0.1, over [-pi, pi]^3.
KnownIndices ishigami() {
  constexpr double a = 7, b = 0.1, pi = M_PI;
  const double v1 = 0.5 * std::pow(1 + b * std::pow(pi, 4) / 5, 2), v2 = a * a / 8,
               v13 = b * b * std::pow(pi, 8) * (1.0 / 18 - 1.0 / 50), v = v1 + v2 + v13;
  return {[pi](const VectorXd& u) {
            const VectorXd x = pi * (2 * u.array() - 1);
            return std::sin(x[0]) + a * std::pow(std::sin(x[1]), 2) +
                   b * std::pow(x[2], 4) * std::sin(x[0]);
          },
          Eigen::Vector3d(v1, v2, 0) / v, Eigen::Vector3d(v1 + v13, v2, v13) / v};
}

KnownIndices linear() {
  const Eigen::Vector3d c(3, 2, 1), shares = c.cwiseAbs2() / c.squaredNorm();
  return {[c](const VectorXd& u) { return c.dot(u); }, shares, shares};
}

// Share of the intervals that hold their index, and root mean square error of the estimates.
struct IntervalQuality {
  double covered = 0, error = 0;
};

IntervalQuality interval_quality(const KnownIndices& known, int samples) {
  constexpr int seeds = 200;
  const Index d = known.first.size();
  IntervalQuality quality;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const SobolIndices s = sobol_indices(known.f, static_cast<int>(d), samples, seed);
    const auto see = [&](const VectorXd& estimate, const MatrixX2d& interval,
                         const VectorXd& truth) {
      for (Index i = 0; i < d; ++i) {
        EXPECT_LE(interval(i, 0), estimate[i]);
        EXPECT_GE(interval(i, 1), estimate[i]);
        quality.covered += interval(i, 0) <= truth[i] && truth[i] <= interval(i, 1);
        quality.error += std::pow(estimate[i] - truth[i], 2);
      }
    };
    see(s.first, s.first_interval, known.first);
    see(s.total, s.total_interval, known.total);
  }
  const double count = 2.0 * static_cast<double>(d) * seeds;
  return {quality.covered / count, std::sqrt(quality.error / count)};
}

// 1200 intervals, those of a seed not independent of each other: three standard deviations of the
// binomial distribution are 0.019 to 0.046.
TEST(SobolIndices, IntervalsHoldTheIndicesIn95Percent) {
  struct Member {
    KnownIndices known;
    int samples;
    double error;
  };
  for (const Member& m : {Member{ishigami(), 2048, 0.016}, Member{ishigami(), 512, 0.06},
                          Member{linear(), 2048, 0.004}, Member{linear(), 512, 0.012}}) {
    const IntervalQuality quality = interval_quality(m.known, m.samples);
    EXPECT_NEAR(quality.covered, 0.95, 0.03) << m.samples;
    EXPECT_LT(quality.error, m.error) << m.samples;
    EXPECT_GT(quality.error, 0) << m.samples;
  }
}

TEST(SobolIndices, FollowFromTheSeed) {
  const KnownIndices known = ishigami();
  const SobolIndices a = sobol_indices(known.f, 3, 256, 1), b = sobol_indices(known.f, 3, 256, 1),
                     c = sobol_indices(known.f, 3, 256, 2);
  EXPECT_EQ(a.first, b.first);
  EXPECT_EQ(a.total_interval, b.total_interval);
  EXPECT_NE(a.first, c.first);
}

TEST(SobolIndices, OfAConstantAreNothing) {
  const SobolIndices s = sobol_indices([](const VectorXd&) { return 3.0; }, 2, 64);
  EXPECT_EQ(s.variance, 0);
  EXPECT_TRUE(s.first.isZero() && s.total.isZero());
  EXPECT_TRUE(s.first_interval.isZero() && s.total_interval.isZero());
}

// A linear function of many parameters: the last bases of the points are large.
TEST(SobolIndices, OfManyParameters) {
  const SobolIndices s = sobol_indices([](const VectorXd& u) { return u.sum(); }, 12, 4096);
  for (Index i = 0; i < 12; ++i) {
    EXPECT_NEAR(s.first[i], 1.0 / 12, 0.03);
    EXPECT_NEAR(s.total[i], 1.0 / 12, 0.01);
  }
}

TEST(RandomizedHalton, PointsAreUniformAndStratified) {
  std::mt19937_64 random(3);
  const Eigen::MatrixXd points = randomized_halton(210, 4, random);
  EXPECT_GE(points.minCoeff(), 0);
  EXPECT_LT(points.maxCoeff(), 1);
  // Every interval of a base holds as many points: 210 = 2 * 3 * 5 * 7.
  for (const auto& [k, base] : {std::pair(0, 2), std::pair(1, 3), std::pair(2, 5), std::pair(3, 7)})
    for (int cell = 0; cell < base; ++cell) {
      const auto inside = (points.col(k).array() * base).floor() == cell;
      EXPECT_EQ(inside.count(), 210 / base) << base;
    }
  EXPECT_NE(points, randomized_halton(210, 4, random));
}

}  // namespace
}  // namespace firn
