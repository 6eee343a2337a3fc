#include "calibrate/optimization/event_probability.h"

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <random>

#include "calibrate/numerics/experimental_design.h"

namespace firn {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double prior_sd_middle = 3, prior_sd_slope = 5;

VectorXd features(const VectorXd& u) {
  VectorXd h(u.size() + 1);
  h << 1, (u.array() - 0.5).matrix();
  return h;
}

double logistic(double x) { return 1 / (1 + std::exp(-x)); }

// Minus the logarithm of the posterior density of the coefficients, up to a constant; convex.
class LogisticPosterior {
 public:
  LogisticPosterior(const std::vector<EventCount>& counts, int coefficients)
      : precision_(VectorXd::Constant(coefficients, 1 / (prior_sd_slope * prior_sd_slope))) {
    precision_[0] = 1 / (prior_sd_middle * prior_sd_middle);
    for (const EventCount& c : counts)
      if (c.runs > 0) sites_.push_back({features(c.u), c.events, c.runs});
  }

  double cost(const VectorXd& b) const {
    double sum = 0.5 * b.dot(precision_.cwiseProduct(b));
    for (const Site& s : sites_) {
      const double x = s.h.dot(b);  // ln(1 + e^x) without an overflow
      sum += s.runs * (std::log1p(std::exp(-std::abs(x))) + std::max(x, 0.0)) - s.events * x;
    }
    return sum;
  }

  // The mode by Newton's method, and the curvature there.
  std::pair<VectorXd, Eigen::LLT<MatrixXd>> mode() const {
    constexpr int most_iterations = 100;
    constexpr double converged = 1e-10;
    VectorXd b = VectorXd::Zero(precision_.size());
    Eigen::LLT<MatrixXd> curvature;
    for (int iteration = 0; iteration < most_iterations; ++iteration) {
      VectorXd gradient = precision_.cwiseProduct(b);
      MatrixXd hessian = precision_.asDiagonal();
      for (const Site& s : sites_) {
        const double p = logistic(s.h.dot(b));
        gradient += (s.runs * p - s.events) * s.h;
        hessian += s.runs * p * (1 - p) * s.h * s.h.transpose();
      }
      curvature.compute(hessian);
      const VectorXd step = curvature.solve(gradient);
      if (step.norm() < converged) break;
      double share = 1;  // a whole step may pass the minimum
      while (share > converged && cost(b - share * step) > cost(b)) share /= 2;
      b -= share * step;
    }
    return {b, curvature};
  }

 private:
  struct Site {
    VectorXd h;
    int events, runs;
  };
  VectorXd precision_;  // of the prior
  std::vector<Site> sites_;
};

}  // namespace

EventProbability::EventProbability(const std::vector<EventCount>& counts, int dimensions) {
  constexpr int count = 1000;
  constexpr double freedom = 5;  // heavier tails than those of the posterior
  constexpr std::uint64_t seed = 1;
  const int coefficients = dimensions + 1;
  const LogisticPosterior posterior(counts, coefficients);
  const auto [mode, curvature] = posterior.mode();
  std::mt19937_64 random(seed);
  // One more dimension for the squared length of the Student deviate.
  const MatrixXd places = randomized_halton(count, coefficients + 1, random);
  const boost::math::normal gaussian;
  const boost::math::chi_squared length(freedom);
  samples_.resize(coefficients, count);
  weights_.resize(count);
  for (Index i = 0; i < count; ++i) {
    VectorXd z(coefficients);
    for (Index k = 0; k < coefficients; ++k) z[k] = boost::math::quantile(gaussian, places(i, k));
    z *= std::sqrt(freedom / boost::math::quantile(length, places(i, coefficients)));
    samples_.col(i) = mode + curvature.matrixU().solve(z);
    const double log_proposal =
        -0.5 * (freedom + coefficients) * std::log1p(z.squaredNorm() / freedom);
    weights_[i] = -posterior.cost(samples_.col(i)) - log_proposal;
  }
  weights_ = (weights_.array() - weights_.maxCoeff()).exp();
  weights_ /= weights_.sum();
}

EventProbability::Prediction EventProbability::predict(const VectorXd& u, double limit) const {
  const double most = std::log(limit / (1 - limit));
  const VectorXd logits = samples_.transpose() * features(u);
  return {weights_.dot(logits.unaryExpr(&logistic)),
          weights_.dot((logits.array() <= most).cast<double>().matrix())};
}

}  // namespace firn
