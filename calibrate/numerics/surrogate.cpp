#include "calibrate/numerics/surrogate.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <random>

#include "calibrate/numerics/matern.h"
#include "calibrate/numerics/optimize.h"
#include "experiments/analysis/random_stream.h"

namespace firn {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Prior standard deviations of the trend's coefficients, in units of the spread of the data, for
// coordinates from -1 to 1.
constexpr double level_prior_sd = 10, slope_prior_sd = 10, curvature_prior_sd = 1;
// The same for the bias of a low fidelity. The level is as large as the spread of the response,
// slopes and curvature are smaller. The curvature is not excluded, although a few points in both
// forms hardly determine it.
constexpr double bias_level_prior_sd = 1, bias_slope_prior_sd = 0.3, bias_curvature_prior_sd = 0.1;
// Priors and ranges of the hyperparameters. The prior medians of the residual are 0.1 of the spread
// for a Gaussian process and 0.02 for lack of fit; that of the correlation length is most of the
// range. The priors prevent overfitting to a few points. With one run at most points, data hardly
// distinguish lack of fit from noise: a larger median overestimates the uncertainty
// (docs/calibration-proof.md).
constexpr double process_guess = 0.1, lack_of_fit_guess = 0.02;
constexpr double gp_residual_spread = 1.2;                 // of ln(sd)
constexpr double length_guess = 0.8, length_spread = 0.6;  // of ln(length)
constexpr double least_gp_residual = 1e-4, most_gp_residual = 3, most_noise = 10;
constexpr double least_length = 0.1, most_length = 5;
constexpr double jitter = 1e-10;
// Number of members of the mixture, sweeps over all hyperparameters between two members, and half
// width of a proposal in the logarithm (Metropolis sampling).
constexpr int members = 8, sweeps = 25;
constexpr double proposal_half_width = 1.2;

// 1, x_i and, if quadratic, all x_i x_j.
VectorXd polynomial(const VectorXd& x, bool quadratic) {
  const Index d = x.size();
  VectorXd h(quadratic ? 1 + d + d * (d + 1) / 2 : 1 + d);
  h[0] = 1;
  h.segment(1, d) = x;
  if (quadratic)
    for (Index i = 0, k = 1 + d; i < d; ++i)
      for (Index j = i; j < d; ++j) h[k++] = x[i] * x[j];
  return h;
}

double log_normal_penalty(double log_value, double guess, double spread) {
  const double d = (log_value - std::log(guess)) / spread;
  return 0.5 * d * d;
}

}  // namespace

std::string SurrogateForm::describe() const {
  std::string s = quadratic ? "quadratic trend" : "linear trend";
  s += matern ? " with a Gaussian process" : " with lack of fit";
  if (logarithm) s += ", of the logarithm";
  return s;
}

Surrogate::Surrogate(const SurrogateData& data, const SurrogateForm& form)
    : data_(data), form_(form) {
  const Index n = data_.y.size(), d = data_.u.cols();
  assert(n >= 2 && data_.u.rows() == n && data_.noise_variance.size() == n);
  VectorXd t(n);
  for (Index i = 0; i < n; ++i) t[i] = transform(data_.y[i]);
  shift_ = t.mean();
  const double spread = std::sqrt((t.array() - shift_).square().sum() / double(n - 1));
  scale_ = spread > 0 ? spread : 1;
  z_ = (t.array() - shift_) / scale_;
  z_noise_ = data_.noise_variance / (scale_ * scale_);
  if (form_.logarithm) z_noise_ = z_noise_.array() / data_.y.array().square();
  if (std::find(data_.low_fidelity.begin(), data_.low_fidelity.end(), true) ==
      data_.low_fidelity.end())
    data_.low_fidelity.clear();
  h_.resize(n, basis(VectorXd::Zero(d)).size());
  for (Index i = 0; i < n; ++i)
    h_.row(i) = basis(data_.u.row(i).transpose(), is_low_fidelity(i)).transpose();
  prior_variance_ = VectorXd::Constant(h_.cols(), curvature_prior_sd * curvature_prior_sd);
  prior_variance_.head(d + 1).setConstant(slope_prior_sd * slope_prior_sd);
  prior_variance_[0] = level_prior_sd * level_prior_sd;
  if (!data_.low_fidelity.empty()) {
    const Index bias = 1 + d + d * (d + 1) / 2, first = h_.cols() - bias;
    prior_variance_.tail(bias).setConstant(bias_curvature_prior_sd * bias_curvature_prior_sd);
    prior_variance_.segment(first, d + 1).setConstant(bias_slope_prior_sd * bias_slope_prior_sd);
    prior_variance_[first] = bias_level_prior_sd * bias_level_prior_sd;
  }
  trend_covariance_ = h_ * prior_variance_.asDiagonal() * h_.transpose();
  fit();
}

double Surrogate::transform(double y) const {
  assert(!form_.logarithm || y > 0);
  return form_.logarithm ? std::log(y) : y;
}

double Surrogate::untransform(double t) const { return form_.logarithm ? std::exp(t) : t; }

double Surrogate::gp_residual_sd() const {
  return std::sqrt(most_likely_.gp_residual_variance) * scale_;
}

const VectorXd& Surrogate::lengths() const { return most_likely_.lengths; }

VectorXd Surrogate::basis(const VectorXd& u, bool low_fidelity) const {
  const VectorXd x = 2 * u.array() - 1;
  VectorXd trend = polynomial(x, form_.quadratic);
  if (data_.low_fidelity.empty()) return trend;
  const VectorXd bias = polynomial(x, true);
  VectorXd h(trend.size() + bias.size());
  h << trend, (low_fidelity ? 1.0 : 0.0) * bias;
  return h;
}

MatrixXd Surrogate::basis_gradient(const VectorXd& u) const {
  const Index d = u.size();
  const VectorXd x = 2 * u.array() - 1;
  MatrixXd g = MatrixXd::Zero(h_.cols(), d);
  for (Index i = 0; i < d; ++i) g(1 + i, i) = 2;
  if (form_.quadratic)
    for (Index i = 0, k = 1 + d; i < d; ++i)
      for (Index j = i; j < d; ++j, ++k) {
        g(k, i) += 2 * x[j];
        g(k, j) += 2 * x[i];
      }
  return g;
}

Surrogate::Member Surrogate::member(const VectorXd& p) const {
  Member m;
  m.gp_residual_variance = std::exp(2 * p[0]);
  m.lengths = p.segment(1, form_.matern ? data_.u.cols() : 0).array().exp();
  if (data_.noise_freedom > 0) m.noise_factor = std::exp(2 * p[p.size() - 1]);
  return m;
}

Eigen::LDLT<MatrixXd> Surrogate::covariance(const Member& m) const {
  const Index n = z_.size();
  MatrixXd k = trend_covariance_;
  // Independent residuals have no covariance between points.
  if (form_.matern)
    for (Index i = 1; i < n; ++i) {
      const MatrixXd apart = data_.u.topRows(i).rowwise() - data_.u.row(i);
      k.row(i).head(i) += m.gp_residual_variance *
                          scaled_norms(apart, m.lengths).unaryExpr(&matern).matrix().transpose();
    }
  k.diagonal().array() += m.gp_residual_variance + m.noise_factor * z_noise_.array() + jitter;
  return Eigen::LDLT<MatrixXd>(k);  // uses the lower triangle alone
}

void Surrogate::factorize(Member& m) const {
  const Index n = z_.size();
  m.covariance = covariance(m);
  m.weights = m.covariance->solve(z_);
  m.precision = m.covariance->solve(MatrixXd::Identity(n, n)).diagonal();
  if (form_.matern) return;
  // Independent residuals: the posterior of the coefficients is sufficient, and no difference of
  // large numbers is needed.
  const VectorXd precision =
      (m.gp_residual_variance + m.noise_factor * z_noise_.array() + jitter).inverse();
  MatrixXd information = h_.transpose() * precision.asDiagonal() * h_;
  information.diagonal() += prior_variance_.cwiseInverse();
  m.coefficient_covariance = information.ldlt().solve(MatrixXd::Identity(h_.cols(), h_.cols()));
  const MatrixXd gain = m.coefficient_covariance * h_.transpose() * precision.asDiagonal();
  m.coefficients = gain * z_;
  m.noise_covariance = m.noise_factor * gain * z_noise_.asDiagonal() * gain.transpose();
}

// Minus the logarithm of likelihood times weight, for the logarithms of residual sd, lengths and,
// unless it is known, noise sd over the stated one.
double Surrogate::objective(const VectorXd& p) const {
  double penalty = log_normal_penalty(p[0], form_.matern ? process_guess : lack_of_fit_guess,
                                      gp_residual_spread);
  const Member m = member(p);
  for (Index i = 0; i < m.lengths.size(); ++i)
    penalty += log_normal_penalty(p[1 + i], length_guess, length_spread);
  // Scaled inverse chi-squared distribution of a variance with `noise_freedom` degrees of freedom.
  penalty += 0.5 * data_.noise_freedom * (std::log(m.noise_factor) + 1 / m.noise_factor);
  const auto factors = covariance(m);
  return 0.5 * z_.dot(factors.solve(z_)) + 0.5 * factors.vectorD().array().log().sum() + penalty;
}

void Surrogate::fit() {
  const Index lengths = form_.matern ? data_.u.cols() : 0;
  const Index count = 1 + lengths + (data_.noise_freedom > 0 ? 1 : 0);
  VectorXd lower(count), upper(count);
  lower.setConstant(-std::log(most_noise));
  upper.setConstant(std::log(most_noise));
  lower[0] = std::log(least_gp_residual);
  upper[0] = std::log(most_gp_residual);
  lower.segment(1, lengths).setConstant(std::log(least_length));
  upper.segment(1, lengths).setConstant(std::log(most_length));
  const Minimum best = minimize([this](const VectorXd& p) { return objective(p); }, lower, upper,
                                60 * static_cast<int>(count));
  // Nothing but NaN: data that no form explains, such as values from 1e-300 to 1e300.
  const VectorXd start = best.x.size() == count ? best.x : VectorXd((lower + upper) / 2);
  most_likely_ = member(start);
  // Metropolis sampling of the posterior, one hyperparameter at a time.
  std::mt19937_64 random(5489);
  VectorXd p = start;
  double here = objective(p);
  for (int i = 1; i <= members * sweeps; ++i) {
    for (Index k = 0; k < count; ++k) {
      VectorXd next = p;
      next[k] += proposal_half_width * (2 * uniform_open(random) - 1);
      const double chance = uniform_open(random);
      if (next[k] < lower[k] || next[k] > upper[k]) continue;
      const double there = objective(next);
      if (!(there - here < -std::log(chance))) continue;
      p = next;
      here = there;
    }
    if (i % sweeps != 0) continue;
    members_.push_back(member(p));
    factorize(members_.back());
  }
  // Where the leave-one-out errors exceed the predicted ones, the variance is inflated.
  inflation_ = std::max(1.0, leave_one_out_z().squaredNorm() / double(z_.size()));
}

Surrogate Surrogate::mixed_with(const Surrogate& other, double share) const {
  Surrogate s = *this;
  s.companion_ = std::make_shared<const Surrogate>(other);
  s.companion_share_ = share;
  return s;
}

Surrogate Surrogate::with_fantasy_point(const VectorXd& u, double noise_variance,
                                        bool low_fidelity) const {
  Surrogate s = *this;
  const Index n = z_.size();
  double y = low_fidelity ? predict_low_fidelity(u).mean : predict_mean(u);
  // The companion, which need not be logarithmic, can bring the mean of both below zero.
  if (form_.logarithm && !(y > 0))
    y = std::max(predict_alone(u, Parts{}, low_fidelity).mean, std::numeric_limits<double>::min());
  if (!data_.low_fidelity.empty()) s.data_.low_fidelity.push_back(low_fidelity);
  s.data_.u.conservativeResize(n + 1, Eigen::NoChange);
  s.data_.u.row(n) = u.transpose();
  s.data_.y.conservativeResize(n + 1);
  s.data_.y[n] = y;
  s.data_.noise_variance.conservativeResize(n + 1);
  s.data_.noise_variance[n] = noise_variance;
  s.z_.conservativeResize(n + 1);
  s.z_[n] = (transform(y) - shift_) / scale_;
  s.z_noise_.conservativeResize(n + 1);
  s.z_noise_[n] = noise_variance / (scale_ * scale_) / (form_.logarithm ? y * y : 1);
  s.h_.conservativeResize(n + 1, Eigen::NoChange);
  s.h_.row(n) = basis(u, low_fidelity).transpose();
  s.trend_covariance_ = s.h_ * s.prior_variance_.asDiagonal() * s.h_.transpose();
  for (Member& m : s.members_) s.factorize(m);
  if (companion_)
    s.companion_ = std::make_shared<const Surrogate>(
        companion_->with_fantasy_point(u, noise_variance, low_fidelity));
  return s;
}

}  // namespace firn
