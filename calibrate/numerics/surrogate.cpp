#include "calibrate/numerics/surrogate.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <random>

#include "calibrate/numerics/optimize.h"
#include "experiments/analysis/random_stream.h"

namespace firn {
namespace {

using Eigen::ArrayXd;
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

// Matern 5/2 correlation as a function of the scaled distance, and its derivative over r^2 / 2.
double matern(double r) {
  const double a = std::sqrt(5.0) * r;
  return (1 + a + a * a / 3) * std::exp(-a);
}
double matern_slope(double r) {
  const double a = std::sqrt(5.0) * r;
  return -5.0 / 3 * (1 + a) * std::exp(-a);
}

// Length of each row of `apart` with its columns in units of `lengths`.
ArrayXd scaled_norms(const MatrixXd& apart, const VectorXd& lengths) {
  return (apart * lengths.cwiseInverse().asDiagonal()).rowwise().norm();
}

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

double Surrogate::discrepancy_sd() const {
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

Prediction Surrogate::predict_low_fidelity(const VectorXd& u) const {
  Prediction p = predict_alone(u, Parts{}, true);
  if (!companion_) return p;
  const Prediction q = companion_->predict_low_fidelity(u);
  const double b = companion_share_, a = 1 - b;
  p.variance = a * p.variance + b * q.variance + a * b * std::pow(p.mean - q.mean, 2);
  p.mean = a * p.mean + b * q.mean;
  return p;
}

FidelityBias Surrogate::fidelity_bias(const VectorXd& u) const {
  if (data_.low_fidelity.empty()) return {};
  const VectorXd h = basis(u, true) - basis(u, false);
  const double share = 1 / static_cast<double>(members_.size());
  double mean = 0, square = 0, variance = 0;
  for (const Member& m : members_) {
    const MemberPrediction one = predict_coefficients(m, h);
    mean += share * one.mean;
    square += share * one.mean * one.mean;
    variance += share * one.variance;
  }
  variance = inflation_ * (variance + std::max(0.0, square - mean * mean));
  FidelityBias bias{scale_ * mean, scale_ * std::sqrt(variance)};
  if (form_.logarithm) {
    const double high = predict_alone(u, Parts{}, false).mean;
    bias = {high * std::expm1(bias.value), high * std::exp(bias.value) * bias.sd};
  }
  if (!companion_) return bias;
  const FidelityBias other = companion_->fidelity_bias(u);
  const double b = companion_share_, a = 1 - b;
  return {a * bias.value + b * other.value,
          std::sqrt(a * bias.sd * bias.sd + b * other.sd * other.sd +
                    a * b * std::pow(bias.value - other.value, 2))};
}

Prediction Surrogate::predict(const VectorXd& u, Parts parts) const {
  Prediction p = predict_alone(u, parts, false);
  if (!companion_) return p;
  const Prediction q = companion_->predict(u, parts);
  const double b = companion_share_, a = 1 - b, apart = p.mean - q.mean;
  if (parts.gradients) {
    p.variance_gradient = a * p.variance_gradient + b * q.variance_gradient +
                          2 * a * b * apart * (p.mean_gradient - q.mean_gradient);
    p.mean_gradient = a * p.mean_gradient + b * q.mean_gradient;
  }
  p.mean = a * p.mean + b * q.mean;
  p.variance = a * p.variance + b * q.variance + a * b * apart * apart;
  p.noise_variance = a * p.noise_variance + b * q.noise_variance;
  return p;
}

Surrogate Surrogate::mixed_with(const Surrogate& other, double share) const {
  Surrogate s = *this;
  s.companion_ = std::make_shared<const Surrogate>(other);
  s.companion_share_ = share;
  return s;
}

Surrogate::Place Surrogate::place(const VectorXd& u, bool gradients, bool low_fidelity) const {
  Place at;
  at.basis = basis(u, low_fidelity);
  if (gradients) at.basis_gradient = basis_gradient(u);
  if (!form_.matern) return at;
  at.prior_basis = prior_variance_.asDiagonal() * at.basis;
  at.prior_variance = at.basis.dot(at.prior_basis);
  at.trend_covariance = h_ * at.prior_basis;
  if (gradients)
    at.trend_covariance_gradient = h_ * (prior_variance_.asDiagonal() * at.basis_gradient);
  at.apart = (-data_.u).rowwise() + u.transpose();
  return at;
}

Surrogate::MemberPrediction Surrogate::predict_polynomial(const Member& m, const Place& at,
                                                          Parts parts) const {
  const VectorXd spread = m.coefficient_covariance * at.basis;
  MemberPrediction p;
  p.mean = at.basis.dot(m.coefficients);
  p.variance = at.basis.dot(spread) + m.gp_residual_variance;
  if (parts.noise) p.noise = at.basis.dot(m.noise_covariance * at.basis);
  if (!parts.gradients) return p;
  p.mean_gradient = at.basis_gradient.transpose() * m.coefficients;
  p.variance_gradient = 2 * at.basis_gradient.transpose() * spread;
  return p;
}

Surrogate::MemberPrediction Surrogate::predict_coefficients(const Member& m,
                                                            const VectorXd& h) const {
  const VectorXd bh = prior_variance_.asDiagonal() * h, k = h_ * bh;
  return {k.dot(m.weights), std::max(0.0, h.dot(bh) - k.dot(m.covariance->solve(k))), 0, {}, {}};
}

void Surrogate::covariance_with_data(const Member& m, const Place& at, Scratch& s) const {
  s.distances = scaled_norms(at.apart, m.lengths);
  s.covariance = at.trend_covariance;
  for (Index i = 0; i < s.distances.size(); ++i)
    s.covariance[i] += m.gp_residual_variance * matern(s.distances[i]);
}

Surrogate::MemberPrediction Surrogate::predict_process(const Member& m, const Place& at,
                                                       Parts parts, Scratch& s) const {
  covariance_with_data(m, at, s);
  const VectorXd& k = s.covariance;
  // The squared half solution avoids the cancellation that k . w has with a wide trend prior.
  s.half = m.covariance->transpositionsP() * k;
  m.covariance->matrixL().solveInPlace(s.half);
  MemberPrediction p;
  p.mean = k.dot(m.weights);
  p.variance = std::max(0.0, at.prior_variance + m.gp_residual_variance -
                                 s.half.dot(s.half.cwiseQuotient(m.covariance->vectorD())));
  if (!parts.noise && !parts.gradients) return p;
  s.solution = s.half.cwiseQuotient(m.covariance->vectorD());
  m.covariance->matrixU().solveInPlace(s.solution);
  const VectorXd w = m.covariance->transpositionsP().transpose() * s.solution;
  if (parts.noise) p.noise = m.noise_factor * w.cwiseAbs2().dot(z_noise_);
  if (!parts.gradients) return p;
  const ArrayXd slopes = m.gp_residual_variance * s.distances.unaryExpr(&matern_slope);
  const MatrixXd dk =
      at.trend_covariance_gradient +
      slopes.matrix().asDiagonal() * at.apart * m.lengths.cwiseAbs2().cwiseInverse().asDiagonal();
  p.mean_gradient = dk.transpose() * m.weights;
  p.variance_gradient = 2 * (at.basis_gradient.transpose() * at.prior_basis - dk.transpose() * w);
  return p;
}

double Surrogate::predict_mean(const VectorXd& u) const {
  const Place at = place(u, false, false);
  const double share = 1 / static_cast<double>(members_.size());
  Scratch scratch;
  double mean = 0;
  for (const Member& m : members_) {
    if (form_.matern) covariance_with_data(m, at, scratch);
    mean +=
        share * (form_.matern ? scratch.covariance.dot(m.weights) : at.basis.dot(m.coefficients));
  }
  mean = untransform(shift_ + scale_ * mean);
  if (!companion_) return mean;
  const double b = companion_share_, a = 1 - b;
  return a * mean + b * companion_->predict_mean(u);
}

Prediction Surrogate::predict_alone(const VectorXd& u, Parts parts, bool low_fidelity) const {
  const Index d = u.size();
  const double share = 1 / static_cast<double>(members_.size());
  const Place at = place(u, parts.gradients, low_fidelity);
  Scratch scratch;
  // Moments of the mixture, standardized: of each member's mean and square, and its variance.
  double mean = 0, square = 0, variance = 0, noise = 0;
  VectorXd mean_gradient = VectorXd::Zero(d), square_gradient = VectorXd::Zero(d),
           variance_gradient = VectorXd::Zero(d);
  for (const Member& m : members_) {
    const MemberPrediction one =
        form_.matern ? predict_process(m, at, parts, scratch) : predict_polynomial(m, at, parts);
    mean += share * one.mean;
    square += share * one.mean * one.mean;
    variance += share * one.variance;
    noise += share * one.noise;
    if (!parts.gradients) continue;
    mean_gradient += share * one.mean_gradient;
    square_gradient += share * 2 * one.mean * one.mean_gradient;
    variance_gradient += share * one.variance_gradient;
  }
  // The variance of the members' means is part of the uncertainty.
  variance = inflation_ * (variance + std::max(0.0, square - mean * mean));
  variance_gradient = inflation_ * (variance_gradient + square_gradient - 2 * mean * mean_gradient);

  Prediction p;
  const double t = shift_ + scale_ * mean, s2 = scale_ * scale_;
  p.mean = untransform(t);
  // dy/dt of the transformation carries spread and slope back to the response.
  const double f = form_.logarithm ? p.mean : 1;
  p.variance = f * f * s2 * variance;
  if (parts.noise) p.noise_variance = f * f * s2 * std::min(variance, noise);
  if (!parts.gradients) return p;
  p.mean_gradient = f * scale_ * mean_gradient;
  p.variance_gradient = f * f * s2 * variance_gradient;
  if (form_.logarithm) p.variance_gradient += 2 * p.variance / f * p.mean_gradient;
  return p;
}

// The members' hyperparameters were drawn from the posterior with this point. Importance weights
// remove its likelihood (Gelfand, Dey and Chang 1992).
Surrogate::LeftOut Surrogate::left_out(Index point) const {
  double sum = 0, error = 0, square = 0;
  for (const Member& m : members_) {
    const double variance = 1 / m.precision[point], e = m.weights[point] * variance;
    const double weight = std::sqrt(variance) * std::exp(0.5 * e * e / variance);
    sum += weight;
    error += weight * e;
    square += weight * (e * e + variance);
  }
  error /= sum;
  return {error, square / sum - error * error,
          std::log(static_cast<double>(members_.size()) / sum)};
}

VectorXd Surrogate::leave_one_out_z() const {
  VectorXd z(z_.size());
  for (Index i = 0; i < z.size(); ++i) {
    const LeftOut l = left_out(i);
    z[i] = l.error / std::sqrt(l.variance);
  }
  return z;
}

VectorXd Surrogate::leave_one_out_errors() const {
  VectorXd errors(z_.size());
  for (Index i = 0; i < errors.size(); ++i)
    errors[i] = left_out(i).error * scale_ * (form_.logarithm ? data_.y[i] : 1);
  return errors;
}

double Surrogate::leave_one_out_score() const {
  double score = 0;
  for (Index i = 0; i < z_.size(); ++i) {
    score += left_out(i).log_density - std::log(scale_);
    if (form_.logarithm) score -= std::log(data_.y[i]);
  }
  return score;
}

Surrogate Surrogate::with_fantasy_point(const VectorXd& u, double noise_variance,
                                        bool low_fidelity) const {
  Surrogate s = *this;
  const Index n = z_.size();
  const double y = low_fidelity ? predict_low_fidelity(u).mean : predict_mean(u);
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

SurrogateChoice choose_surrogate(const SurrogateData& data) {
  // A process with a length for each parameter needs more points than a polynomial.
  const bool enough_for_matern = data.y.size() >= 3 * data.u.cols() + 1;
  constexpr double least_of_logarithm = 1e-30;  // the square of one below it may vanish
  const bool positive = data.y.minCoeff() > least_of_logarithm;
  std::vector<Surrogate> candidates;
  for (const bool logarithm : {false, true}) {
    if (logarithm && !positive) continue;
    candidates.emplace_back(data, SurrogateForm{false, false, logarithm});
    candidates.emplace_back(data, SurrogateForm{true, false, logarithm});
    if (enough_for_matern) candidates.emplace_back(data, SurrogateForm{false, true, logarithm});
  }
  // A difference of half a unit of log density is negligible: the earlier, simpler form is kept.
  constexpr double near_tie = 0.5;
  const auto pick = [&](auto&& allowed) {
    const Surrogate* best = nullptr;
    for (const Surrogate& s : candidates)
      if (allowed(s.form()) &&
          (best == nullptr || s.leave_one_out_score() > best->leave_one_out_score() + near_tie))
        best = &s;
    return best;
  };
  const Surrogate* best = pick([](const SurrogateForm&) { return true; });
  const Surrogate* other = pick([&](const SurrogateForm& f) {
    return f.matern != best->form().matern || f.quadratic != best->form().quadratic;
  });
  // Weights by predictive density (pseudo Bayesian model averaging).
  constexpr double negligible = 0.02;
  const double share =
      1 / (1 + std::exp(best->leave_one_out_score() - other->leave_one_out_score()));
  return {share > negligible ? best->mixed_with(*other, share) : *best, *other};
}

}  // namespace firn
