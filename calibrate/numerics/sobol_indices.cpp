#include "calibrate/numerics/sobol_indices.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "calibrate/numerics/experimental_design.h"

namespace firn {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// First-order and total indices from rows of evaluations, each of which counts `weight` times.
void estimate(const VectorXd& fa, const VectorXd& fb, const MatrixXd& fab, const VectorXd& weight,
              SobolIndices& s) {
  const Index d = fab.cols();
  const double n = weight.sum();
  const double mean = 0.5 * (weight.dot(fa) + weight.dot(fb)) / n;
  const auto squares = [&](const VectorXd& f) {
    return weight.dot((f.array() - mean).square().matrix()) / n;
  };
  s.variance = 0.5 * (squares(fa) + squares(fb));
  s.first = VectorXd::Zero(d);
  s.total = VectorXd::Zero(d);
  if (!(s.variance > 0)) return;
  for (Index i = 0; i < d; ++i) {
    const VectorXd change = fab.col(i) - fa;
    s.first[i] = weight.dot(((fb.array() - mean) * change.array()).matrix()) / n / s.variance;
    s.total[i] = 0.5 * weight.dot(change.array().square().matrix()) / n / s.variance;
  }
}

// The 2.5 % and 97.5 % quantiles of each column.
Eigen::MatrixX2d intervals(MatrixXd estimates) {
  Eigen::MatrixX2d ends(estimates.cols(), 2);
  const auto last = static_cast<double>(estimates.rows() - 1);
  for (Index i = 0; i < estimates.cols(); ++i) {
    auto column = estimates.col(i);
    std::sort(column.begin(), column.end());
    ends(i, 0) = column[std::lround(0.025 * last)];
    ends(i, 1) = column[std::lround(0.975 * last)];
  }
  return ends;
}

}  // namespace

SobolIndices sobol_indices(const std::function<double(const VectorXd&)>& f, int parameters,
                           int samples) {
  const Index d = parameters, n = samples;
  VectorXd fa(n), fb(n);
  Eigen::MatrixXd fab(n, d);  // of a with one coordinate from b
  for (Index s = 0; s < n; ++s) {
    const VectorXd both = quasi_random_point(static_cast<std::uint64_t>(s), 2 * parameters);
    const VectorXd a = both.head(d), b = both.tail(d);
    fa[s] = f(a);
    fb[s] = f(b);
    for (Index i = 0; i < d; ++i) {
      VectorXd ab = a;
      ab[i] = b[i];
      fab(s, i) = f(ab);
    }
  }
  SobolIndices indices;
  estimate(fa, fb, fab, VectorXd::Ones(n), indices);
  constexpr Index resamples = 200;
  MatrixXd first(resamples, d), total(resamples, d);
  std::mt19937_64 random(20101);
  for (Index r = 0; r < resamples; ++r) {
    VectorXd weight = VectorXd::Zero(n);
    for (Index s = 0; s < n; ++s)
      weight[static_cast<Index>(random() % static_cast<std::uint64_t>(n))] += 1;
    SobolIndices resampled;
    estimate(fa, fb, fab, weight, resampled);
    first.row(r) = resampled.first;
    total.row(r) = resampled.total;
  }
  indices.first_interval = intervals(std::move(first));
  indices.total_interval = intervals(std::move(total));
  return indices;
}

}  // namespace firn
