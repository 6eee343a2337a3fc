#include "calibrate/surrogate.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>

#include "calibrate/optimize.h"

namespace firn {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Standard deviations believed of the trend's coefficients, in units of the spread of the data,
// for coordinates that run from -1 to 1.
constexpr double level_belief = 10, slope_belief = 10, curvature_belief = 1;
// Where departure and length are looked for and what is thought of them beforehand: a tenth of the
// spread, and shapes as wide as most of the range. Keeps a handful of points from choosing wonders.
constexpr double departure_guess = 0.1, departure_spread = 1.2;  // of ln(sd)
constexpr double length_guess = 0.8, length_spread = 0.6;        // of ln(length)
constexpr double jitter = 1e-10;

// Matern 5/2 correlation as a function of the scaled distance, and its derivative over r^2 / 2.
double matern(double r) {
  const double a = std::sqrt(5.0) * r;
  return (1 + a + a * a / 3) * std::exp(-a);
}
double matern_slope(double r) {
  const double a = std::sqrt(5.0) * r;
  return -5.0 / 3 * (1 + a) * std::exp(-a);
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
  h_.resize(n, basis(VectorXd::Zero(d)).size());
  for (Index i = 0; i < n; ++i) h_.row(i) = basis(data_.u.row(i).transpose()).transpose();
  belief_ = VectorXd::Constant(h_.cols(), curvature_belief * curvature_belief);
  belief_.head(d + 1).setConstant(slope_belief * slope_belief);
  belief_[0] = level_belief * level_belief;
  lengths_ = VectorXd::Constant(form_.matern ? d : 0, length_guess);
  fit();
}

double Surrogate::transform(double y) const {
  assert(!form_.logarithm || y > 0);
  return form_.logarithm ? std::log(y) : y;
}

double Surrogate::departure_sd() const { return std::sqrt(departure_variance_) * scale_; }

VectorXd Surrogate::basis(const VectorXd& u) const {
  const Index d = u.size();
  const VectorXd x = 2 * u.array() - 1;
  VectorXd h(form_.quadratic ? 1 + d + d * (d + 1) / 2 : 1 + d);
  h[0] = 1;
  h.segment(1, d) = x;
  if (form_.quadratic)
    for (Index i = 0, k = 1 + d; i < d; ++i)
      for (Index j = i; j < d; ++j) h[k++] = x[i] * x[j];
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

// Of the departure between two different places; independent departures share nothing.
double Surrogate::kernel(const VectorXd& a, const VectorXd& b) const {
  if (!form_.matern) return 0;
  return departure_variance_ * matern(((a - b).array() / lengths_.array()).matrix().norm());
}

VectorXd Surrogate::kernel_gradient(const VectorXd& a, const VectorXd& b) const {
  if (!form_.matern) return VectorXd::Zero(a.size());
  const double r = ((a - b).array() / lengths_.array()).matrix().norm();
  return departure_variance_ * matern_slope(r) *
         ((a - b).array() / lengths_.array().square()).matrix();
}

void Surrogate::factorize() {
  const Index n = z_.size();
  MatrixXd k = h_ * belief_.asDiagonal() * h_.transpose();
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < i; ++j) {
      const double c = kernel(data_.u.row(i).transpose(), data_.u.row(j).transpose());
      k(i, j) += c;
      k(j, i) += c;
    }
    k(i, i) += departure_variance_ + z_noise_[i] + jitter;
  }
  covariance_.compute(k);
  weights_ = covariance_.solve(z_);
}

// Minus the logarithm of likelihood times belief, for ln(departure sd) and ln(lengths).
double Surrogate::objective(const VectorXd& p) {
  departure_variance_ = std::exp(2 * p[0]);
  double penalty = log_normal_penalty(p[0], departure_guess, departure_spread);
  for (Index i = 0; i < lengths_.size(); ++i) {
    lengths_[i] = std::exp(p[1 + i]);
    penalty += log_normal_penalty(p[1 + i], length_guess, length_spread);
  }
  factorize();
  return 0.5 * z_.dot(weights_) + 0.5 * covariance_.vectorD().array().log().sum() + penalty;
}

void Surrogate::fit() {
  const Index count = 1 + lengths_.size();
  VectorXd lower = VectorXd::Constant(count, std::log(0.1));
  VectorXd upper = VectorXd::Constant(count, std::log(5.0));
  lower[0] = std::log(1e-4);
  upper[0] = std::log(3.0);
  const Minimum best = minimize([this](const VectorXd& p) { return objective(p); }, lower, upper,
                                60 * static_cast<int>(count));
  objective(best.x);
  inverse_ = covariance_.solve(MatrixXd::Identity(z_.size(), z_.size()));
  // Where its own points, left out, contradict the form by more than it believes, it believes less.
  inflation_ = std::max(1.0, leave_one_out_z().squaredNorm() / double(z_.size()));
}

Prediction Surrogate::predict(const VectorXd& u) const {
  const Index n = z_.size(), d = u.size();
  const VectorXd h = basis(u), bh = belief_.asDiagonal() * h;
  const MatrixXd dh = basis_gradient(u);
  VectorXd k = h_ * bh;
  MatrixXd dk = h_ * (belief_.asDiagonal() * dh);  // [points, parameters]
  for (Index i = 0; i < n; ++i) {
    k[i] += kernel(u, data_.u.row(i).transpose());
    dk.row(i) += kernel_gradient(u, data_.u.row(i).transpose()).transpose();
  }
  const VectorXd w = inverse_ * k;
  const double variance = inflation_ * std::max(0.0, h.dot(bh) + departure_variance_ - k.dot(w));
  const double noise = std::min(variance, w.cwiseAbs2().dot(z_noise_));
  const VectorXd mean_gradient = dk.transpose() * weights_;
  const VectorXd variance_gradient = 2 * inflation_ * (dh.transpose() * bh - dk.transpose() * w);

  Prediction p;
  const double t = shift_ + scale_ * k.dot(weights_), s2 = scale_ * scale_;
  p.mean = form_.logarithm ? std::exp(t) : t;
  // dy/dt of the transformation carries spread and slope back to the response.
  const double f = form_.logarithm ? p.mean : 1;
  p.mean_gradient = f * scale_ * mean_gradient;
  p.variance = f * f * s2 * variance;
  p.noise_variance = f * f * s2 * noise;
  p.variance_gradient = f * f * s2 * variance_gradient;
  if (form_.logarithm) p.variance_gradient += 2 * p.variance / f * p.mean_gradient;
  assert(p.mean_gradient.size() == d);
  return p;
}

VectorXd Surrogate::leave_one_out_z() const {
  return weights_.array() / inverse_.diagonal().array().sqrt();
}

double Surrogate::leave_one_out_score() const {
  const VectorXd z = leave_one_out_z();
  double score = 0;
  for (Index i = 0; i < z.size(); ++i) {
    score += 0.5 * std::log(inverse_(i, i)) - 0.5 * z[i] * z[i] - std::log(scale_);
    if (form_.logarithm) score -= std::log(data_.y[i]);
  }
  return score;
}

Surrogate Surrogate::with_believed_point(const VectorXd& u, double noise_variance) const {
  Surrogate s = *this;
  const Index n = z_.size();
  const double y = predict(u).mean;
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
  s.h_.row(n) = basis(u).transpose();
  s.factorize();
  s.inverse_ = s.covariance_.solve(MatrixXd::Identity(n + 1, n + 1));
  return s;
}

SurrogateChoice choose_surrogate(const SurrogateData& data) {
  // A process with a length for each parameter asks for more points than a polynomial.
  const bool enough_for_matern = data.y.size() >= 3 * data.u.cols() + 1;
  const bool positive = data.y.minCoeff() > 0;
  std::vector<Surrogate> candidates;
  for (const bool logarithm : {false, true}) {
    if (logarithm && !positive) continue;
    candidates.emplace_back(data, SurrogateForm{false, false, logarithm});
    candidates.emplace_back(data, SurrogateForm{true, false, logarithm});
    if (enough_for_matern) candidates.emplace_back(data, SurrogateForm{false, true, logarithm});
  }
  // Half a unit of log density is nothing between models: the earlier, simpler one stays.
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
  return {*best, *other};
}

}  // namespace firn
