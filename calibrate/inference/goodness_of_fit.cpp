#include "calibrate/inference/goodness_of_fit.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>

namespace firn {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double significance = 0.05;
constexpr double at_border = 0.002;  // unit cube

bool free_at(double u) { return u > at_border && u < 1 - at_border; }

// Directions of the free parameters that the residuals determine: those that they hardly determine
// count by the part by which they narrow the range.
double determined_directions(const Study& study, const ResponseModels& models, const VectorXd& u,
                             Priors priors) {
  const Index targets = static_cast<Index>(study.targets.size()), d = u.size();
  Index beliefs = 0;
  for (const Prior& prior : study.priors) beliefs += prior.residuals();
  MatrixXd jacobian = MatrixXd::Zero(targets + d + beliefs, d);
  for (Index k = 0; k < targets; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const Prediction p = models.targets[i].surrogate.best.predict_with_gradients(u);
    jacobian.row(k) =
        p.mean_gradient.transpose() / std::hypot(study.targets[i].sd(), std::sqrt(p.variance));
  }
  for (Index i = 0; i < d; ++i) {
    const auto sd = study.parameters[static_cast<std::size_t>(i)].prior_sd_unit();
    if (sd && priors == Priors::with) jacobian(targets + i, i) = 1 / *sd;
  }
  Index row = targets + d;
  VectorXd r;
  MatrixXd slopes;
  for (const Prior& prior : study.priors) {
    if (priors == Priors::without) break;
    prior_residuals(prior, study.parameters, u, r, slopes);
    jacobian.middleRows(row, slopes.rows()) = slopes;
    row += slopes.rows();
  }
  for (Index i = 0; i < d; ++i)
    if (!free_at(u[i])) jacobian.col(i).setZero();
  constexpr double range_precision = 12;  // of a uniform distribution over the range
  double sum = 0;
  const VectorXd singular = Eigen::JacobiSVD<MatrixXd>(jacobian).singularValues();
  for (const double s : singular) sum += s * s / (s * s + range_precision);
  return sum;
}

}  // namespace

double chi_square_tail(double x, double freedom) {
  if (!(x > 0)) return 1;
  if (!std::isfinite(x)) return 0;
  return boost::math::cdf(complement(boost::math::chi_squared(freedom), x));
}

bool GoodnessOfFit::acceptable() const { return probability >= significance; }

GoodnessOfFit goodness_of_fit(const Study& study, const ResponseModels& models,
                              const VectorXd& start, Priors priors) {
  const NegativeLogPosterior misfit(study, models);
  const Index d = start.size();
  const auto prior_squares = [&](const VectorXd& u) {
    return prior_cost(study.priors, study.parameters, u);
  };
  const auto cost = [&](const VectorXd& u) {
    return misfit.cost(u) - (priors == Priors::without ? prior_squares(u) : 0);
  };
  GoodnessOfFit g;
  g.u = start;
  double least = cost(start);
  for (const double step : {0.2, 0.02}) {
    const Minimum m = minimize_locally(cost, VectorXd::Zero(d), VectorXd::Ones(d), g.u, step, 150);
    if (!(m.value < least)) continue;
    least = m.value;
    g.u = m.x;
  }
  const VectorXd z = misfit.z(g.u);
  g.z.assign(z.begin(), z.end());
  g.chi_square = z.squaredNorm() + (priors == Priors::with ? prior_squares(g.u) : 0);
  double residuals = static_cast<double>(z.size());
  if (priors == Priors::with) residuals += prior_count(study.priors, study.parameters);
  g.freedom = std::max(1.0, residuals - determined_directions(study, models, g.u, priors));
  g.probability = chi_square_tail(g.chi_square, g.freedom);
  return g;
}

}  // namespace firn
