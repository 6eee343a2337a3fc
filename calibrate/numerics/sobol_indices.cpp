#include "calibrate/numerics/sobol_indices.h"

#include <cmath>
#include <random>
#include <vector>

#include "calibrate/numerics/experimental_design.h"

namespace firn {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index replicates = 8;
constexpr double student_975 = 2.3646;  // quantile, replicates - 1 degrees of freedom

// An index, the sum of `parts` over that of `variance` ([replicates] each), and its interval.
void estimate_index(const VectorXd& parts, const VectorXd& variance, double& index,
                    Eigen::RowVector2d& interval) {
  index = parts.sum() / variance.sum();
  const VectorXd residuals = (parts - index * variance) / variance.mean();
  const double error =
      std::sqrt(residuals.squaredNorm() / static_cast<double>((replicates - 1) * replicates));
  interval << index - student_975 * error, index + student_975 * error;
}

}  // namespace

SobolIndices sobol_indices(const std::function<double(const VectorXd&)>& f, int parameters,
                           int samples, std::uint64_t seed) {
  const Index d = parameters, n = samples / replicates;
  MatrixXd fa(n, replicates), fb = fa;
  std::vector<MatrixXd> fab;  // of a with one coordinate from b: [replicates] of [n, parameters]
  std::mt19937_64 random(seed);
  for (Index r = 0; r < replicates; ++r) {
    const MatrixXd points = randomized_halton(static_cast<int>(n), 2 * parameters, random);
    fab.emplace_back(n, d);
    for (Index s = 0; s < n; ++s) {
      const VectorXd a = points.row(s).head(d).transpose(), b = points.row(s).tail(d).transpose();
      fa(s, r) = f(a);
      fb(s, r) = f(b);
      for (Index i = 0; i < d; ++i) {
        VectorXd ab = a;
        ab[i] = b[i];
        fab.back()(s, i) = f(ab);
      }
    }
  }
  const double mean = 0.5 * (fa.mean() + fb.mean());
  VectorXd variance(replicates);
  MatrixXd first(replicates, d), total(replicates, d);
  for (Index r = 0; r < replicates; ++r) {
    const VectorXd a = fa.col(r).array() - mean, b = fb.col(r).array() - mean;
    variance[r] = 0.5 * (a.squaredNorm() + b.squaredNorm()) / static_cast<double>(n);
    for (Index i = 0; i < d; ++i) {
      const VectorXd change = fab[static_cast<std::size_t>(r)].col(i) - fa.col(r);
      first(r, i) = b.dot(change) / static_cast<double>(n);
      total(r, i) = 0.5 * change.squaredNorm() / static_cast<double>(n);
    }
  }
  SobolIndices s{VectorXd::Zero(d), VectorXd::Zero(d), variance.mean(),
                 Eigen::MatrixX2d::Zero(d, 2), Eigen::MatrixX2d::Zero(d, 2)};
  if (!(s.variance > 0)) return s;
  for (Index i = 0; i < d; ++i) {
    Eigen::RowVector2d interval;
    estimate_index(first.col(i), variance, s.first[i], interval);
    s.first_interval.row(i) = interval;
    estimate_index(total.col(i), variance, s.total[i], interval);
    s.total_interval.row(i) = interval;
  }
  return s;
}

}  // namespace firn
