// How often the intervals of Sobol indices hold the indices in closed form.
#include "calibrate/numerics/sobol_indices.h"

#include <gtest/gtest.h>

#include <cmath>

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

// Shares of the intervals that hold their index, and the mean width of an interval over four
// standard deviations of the estimates.
struct IntervalQuality {
  double covered = 0, width = 0;
};

// Each member shifts the unit cube by another vector, periodically: its indices are those of the
// function itself, and its evaluations are others (random rotation of Cranley and Patterson, 1976).
IntervalQuality interval_quality(const KnownIndices& known, int samples) {
  constexpr int members = 100;
  const Index d = known.first.size();
  std::mt19937_64 random(17);
  IntervalQuality quality;
  VectorXd errors = VectorXd::Zero(2 * d), widths = errors;
  for (int m = 0; m < members; ++m) {
    VectorXd shift(d);
    for (Index i = 0; i < d; ++i) shift[i] = std::ldexp(static_cast<double>(random() >> 11), -53);
    const SobolIndices s = sobol_indices(
        [&](const VectorXd& u) {
          const VectorXd moved = u + shift;
          return known.f((moved.array() - moved.array().floor()).matrix());
        },
        static_cast<int>(d), samples);
    const auto see = [&](const VectorXd& estimate, const MatrixX2d& interval, const VectorXd& truth,
                         Index offset) {
      for (Index i = 0; i < d; ++i) {
        EXPECT_LE(interval(i, 0), estimate[i]);
        EXPECT_GE(interval(i, 1), estimate[i]);
        quality.covered += interval(i, 0) <= truth[i] && truth[i] <= interval(i, 1);
        errors[offset + i] += std::pow(estimate[i] - truth[i], 2) / members;
        widths[offset + i] += (interval(i, 1) - interval(i, 0)) / members;
      }
    };
    see(s.first, s.first_interval, known.first, 0);
    see(s.total, s.total_interval, known.total, d);
  }
  quality.covered /= 2.0 * static_cast<double>(d) * members;
  quality.width = (widths.array() / (4 * errors.array().sqrt())).mean();
  return quality;
}

TEST(SobolIndices, IntervalsHoldTheIndicesInAtLeast95Percent) {
  for (const KnownIndices& known : {ishigami(), linear()})
    for (const int samples : {256, 2048}) {
      const IntervalQuality quality = interval_quality(known, samples);
      std::printf("%d %g %g\n", samples, quality.covered, quality.width);
      EXPECT_GE(quality.covered, 0.93);
    }
}

}  // namespace
}  // namespace firn
