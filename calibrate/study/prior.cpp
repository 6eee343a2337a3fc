#include "calibrate/study/prior.h"

#include <algorithm>
#include <cmath>

namespace firn {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double inside = 1e-9;  // of the cube, where a beta density is finite

// Minus twice the logarithm of the density along the scale of the parameter, up to a constant.
double scalar_cost(const Prior& prior, const Parameter& p, double u) {
  if (prior.kind == Prior::Kind::beta) {
    const double x = std::clamp(u, inside, 1 - inside);
    return -2 * ((prior.a - 1) * std::log(x) + (prior.b - 1) * std::log1p(-x));
  }
  const double x = p.from_unit(u);
  if (prior.kind == Prior::Kind::normal) {
    const double z = (x - prior.a) / prior.b;
    return z * z - (p.logarithmic ? 2 * std::log(x) : 0);  // dx = x d(ln x)
  }
  const double z = (std::log(x) - prior.a) / prior.b;
  return z * z + (p.logarithmic ? 0 : 2 * std::log(x));
}

// Where the density along the scale is largest; may lie outside the cube.
double mode(const Prior& prior, const Parameter& p) {
  switch (prior.kind) {
    case Prior::Kind::normal:
      return p.to_unit(p.logarithmic
                           ? 0.5 * (prior.a + std::sqrt(prior.a * prior.a + 4 * prior.b * prior.b))
                           : prior.a);
    case Prior::Kind::log_normal:
      return p.to_unit(std::exp(p.logarithmic ? prior.a : prior.a - prior.b * prior.b));
    case Prior::Kind::beta:
      return (prior.a - 1) / (prior.a + prior.b - 2);
    case Prior::Kind::joint:
      break;
  }
  return 0.5;
}

double scalar_residual(const Prior& prior, const Parameter& p, double u) {
  const double top = mode(prior, p);
  const double above = scalar_cost(prior, p, u) - scalar_cost(prior, p, top);
  return std::copysign(std::sqrt(std::max(above, 0.0)), u - top);
}

}  // namespace

void prior_residuals(const Prior& prior, const std::vector<Parameter>& parameters,
                     const VectorXd& u, VectorXd& r, MatrixXd& jacobian) {
  r.resize(prior.residuals());
  jacobian = MatrixXd::Zero(r.size(), u.size());
  if (prior.kind == Prior::Kind::joint) {
    VectorXd off(r.size());
    for (Index i = 0; i < r.size(); ++i)
      off[i] = u[static_cast<Index>(prior.parameters[static_cast<std::size_t>(i)])] - prior.mean[i];
    const MatrixXd whitening = MatrixXd(prior.covariance.llt().matrixL())
                                   .triangularView<Eigen::Lower>()
                                   .solve(MatrixXd::Identity(r.size(), r.size()));
    r = whitening * off;
    for (Index i = 0; i < r.size(); ++i)
      jacobian.col(static_cast<Index>(prior.parameters[static_cast<std::size_t>(i)])) =
          whitening.col(i);
    return;
  }
  constexpr double step = 1e-4;
  const std::size_t i = prior.parameters.front();
  const auto at = [&](double x) { return scalar_residual(prior, parameters[i], x); };
  const double x = u[static_cast<Index>(i)];
  r[0] = at(x);
  jacobian(0, static_cast<Index>(i)) = (at(x + step) - at(x - step)) / (2 * step);
}

double prior_cost(const std::vector<Prior>& priors, const std::vector<Parameter>& parameters,
                  const VectorXd& u) {
  double sum = 0;
  for (std::size_t i = 0; i < parameters.size(); ++i)
    if (const auto sd = parameters[i].prior_sd_unit())
      sum += std::pow((u[static_cast<Index>(i)] - parameters[i].prior_mean_unit()) / *sd, 2);
  VectorXd r;
  MatrixXd jacobian;
  for (const Prior& prior : priors) {
    if (prior.kind == Prior::Kind::joint) {
      prior_residuals(prior, parameters, u, r, jacobian);
      sum += r.squaredNorm();
    } else {
      const std::size_t i = prior.parameters.front();
      sum += std::pow(scalar_residual(prior, parameters[i], u[static_cast<Index>(i)]), 2);
    }
  }
  return sum;
}

int prior_count(const std::vector<Prior>& priors, const std::vector<Parameter>& parameters) {
  int count = 0;
  for (const Parameter& p : parameters) count += p.prior_sd_unit() ? 1 : 0;
  for (const Prior& prior : priors) count += static_cast<int>(prior.residuals());
  return count;
}

double prior_sd(const std::vector<Prior>& priors, const std::vector<Parameter>& parameters,
                std::size_t index) {
  const Parameter& p = parameters[index];
  const auto cost = [&](double x) {
    double sum = 0;
    if (const auto sd = p.prior_sd_unit()) {
      const double z = (x - p.prior_mean_unit()) / *sd;
      sum += z * z;
    }
    for (const Prior& prior : priors)
      for (std::size_t k = 0; k < prior.parameters.size(); ++k) {
        if (prior.parameters[k] != index) continue;
        const auto i = static_cast<Index>(k);
        sum += prior.kind == Prior::Kind::joint
                   ? std::pow(x - prior.mean[i], 2) / prior.covariance(i, i)
                   : std::pow(scalar_residual(prior, p, x), 2);
      }
    return sum;
  };
  constexpr int cells = 1000;
  double w0 = 0, w1 = 0, w2 = 0;
  for (int i = 0; i < cells; ++i) {
    const double x = (i + 0.5) / cells;
    const double w = std::exp(-0.5 * cost(x));
    w0 += w;
    w1 += w * x;
    w2 += w * x * x;
  }
  return std::sqrt(w2 / w0 - (w1 / w0) * (w1 / w0));
}

}  // namespace firn
