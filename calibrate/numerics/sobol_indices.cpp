#include "calibrate/numerics/sobol_indices.h"

#include <vector>

#include "calibrate/numerics/experimental_design.h"

namespace firn {

using Eigen::Index;
using Eigen::VectorXd;

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
  const double mean = 0.5 * (fa.mean() + fb.mean());
  SobolIndices indices;
  indices.variance =
      0.5 * ((fa.array() - mean).square().mean() + (fb.array() - mean).square().mean());
  indices.first = VectorXd::Zero(d);
  indices.total = VectorXd::Zero(d);
  if (!(indices.variance > 0)) return indices;
  for (Index i = 0; i < d; ++i) {
    indices.first[i] = ((fb.array() - mean) * (fab.col(i) - fa).array()).mean() / indices.variance;
    indices.total[i] = 0.5 * (fa - fab.col(i)).squaredNorm() / double(n) / indices.variance;
  }
  return indices;
}

}  // namespace firn
