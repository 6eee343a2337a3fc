// Predictions of a surrogate, with gradients and parts of the variance, and its leave-one-out
// errors.
#include <algorithm>
#include <cmath>

#include "calibrate/numerics/matern.h"
#include "calibrate/numerics/surrogate.h"

namespace firn {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

}  // namespace

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

}  // namespace firn
