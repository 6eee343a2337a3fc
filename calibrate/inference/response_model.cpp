#include "calibrate/inference/response_model.h"

#include <algorithm>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <limits>

namespace firn {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double pull_sd = 1;             // of the weak pull, in ranges
constexpr double share_reach = 0.15;      // width of the smoothing, unit cube
constexpr double share_prior_runs = 0.5;  // runs that end otherwise, believed everywhere
constexpr int search_evaluations = 600;

double log_likelihood(const std::vector<Sample>& samples, bool relative, double sd) {
  double sum = 0;
  for (const Sample& s : samples) {
    if (s.count < 2) continue;
    const double variance = std::pow(sd * (relative ? s.mean : 1), 2);
    sum -= 0.5 * ((s.count - 1) * std::log(variance) + s.sum_of_squares / variance);
  }
  return sum;
}

double pooled_sd(const std::vector<Sample>& samples, bool relative, int degrees_of_freedom) {
  double sum = 0;
  for (const Sample& s : samples)
    if (s.count >= 2) sum += s.sum_of_squares / (relative ? s.mean * s.mean : 1);
  return std::sqrt(sum / degrees_of_freedom);
}

bool inside(const VectorXd& u) { return u.minCoeff() >= -1e-9 && u.maxCoeff() <= 1 + 1e-9; }

// Estimates of the noise: from the scatter of points with several seeds, and from the
// leave-one-out residuals of the others, weighted by the part of the residual that is noise.
std::vector<NoiseSite> noise_sites(const ResponseModel& m, const SurrogateData& data) {
  const VectorXd z = m.surrogate.best.leave_one_out_z();
  std::vector<NoiseSite> sites;
  for (Index i = 0; i < data.y.size(); ++i) {
    const Sample& s = m.samples[static_cast<std::size_t>(i)];
    const double pooled = std::pow(m.noise.at(s.mean), 2);
    if (!(pooled > 0)) continue;
    const VectorXd u = data.u.row(i).transpose();
    if (s.count >= 2) {
      sites.push_back({u, s.sum_of_squares / pooled, s.count - 1.0});
    } else {
      const bool low = !data.low_fidelity.empty() && data.low_fidelity[static_cast<std::size_t>(i)];
      const Surrogate& best = m.surrogate.best;
      const Prediction there = low ? best.predict_low_fidelity(u) : best.predict(u);
      const double share = pooled / (pooled + there.variance);
      sites.push_back({u, share * z[i] * z[i], share});
    }
  }
  return sites;
}

}  // namespace

std::optional<ResponseModel> fit_response_model(const ResponseId& response,
                                                const std::vector<Point>& points,
                                                const std::vector<Point>& elsewhere) {
  std::vector<const Point*> used;
  std::vector<Sample> samples, all, others;
  std::string unit;
  for (const Point& p : points) {
    const Sample s = sample(p.finished(response));
    if (s.count == 0) continue;
    all.push_back(s);  // a point outside the ranges still informs the noise model
    if (!inside(p.u)) continue;
    used.push_back(&p);
    samples.push_back(s);
    unit = p.unit(response);
  }
  for (const Point& p : elsewhere)
    if (const Sample s = sample(p.finished(response)); s.count > 0) others.push_back(s);
  const auto noise = pool_noise(all, others);
  const Index d = points.empty() ? 0 : points.front().u.size(), n = static_cast<Index>(used.size());
  if (!noise || n < d + 2) return std::nullopt;
  SurrogateData data{MatrixXd(n, d), VectorXd(n), VectorXd(n), 0};
  for (Index i = 0; i < n; ++i) {
    const Sample& s = samples[static_cast<std::size_t>(i)];
    data.u.row(i) = used[static_cast<std::size_t>(i)]->u.transpose();
    data.y[i] = s.mean;
    data.noise_variance[i] = std::pow(noise->at(s.mean), 2) / s.count;
    data.low_fidelity.push_back(
        used[static_cast<std::size_t>(i)]->is_low_fidelity(response.experiment));
  }
  data.noise_freedom = noise->degrees_of_freedom;
  ResponseModel m{response, unit, *noise, choose_surrogate(data), samples, infinity, -infinity, 0};
  // A low fidelity says nothing of the range without its bias.
  const bool all_low = std::find(data.low_fidelity.begin(), data.low_fidelity.end(), false) ==
                       data.low_fidelity.end();
  for (Index i = 0; i < n; ++i) {
    if (data.low_fidelity[static_cast<std::size_t>(i)] && !all_low) continue;
    m.lowest = std::min(m.lowest, data.y[i]);
    m.highest = std::max(m.highest, data.y[i]);
  }
  m.noise_sites = noise_sites(m, data);
  m.local_noise = LocalNoise(m.noise_sites);
  if (!m.local_noise.uniform()) {
    for (Index i = 0; i < n; ++i)
      data.noise_variance[i] *= m.local_noise.factor(data.u.row(i).transpose());
    m.surrogate = choose_surrogate(data);
  }
  m.largest_leave_one_out_z = m.surrogate.best.leave_one_out_z().cwiseAbs().maxCoeff();
  return m;
}

bool ResponseModel::passes_cross_validation() const {
  const double points = static_cast<double>(samples.size());
  return points * std::erfc(largest_leave_one_out_z / std::sqrt(2.0)) > 0.01;
}

double ResponseModel::run_variance(const VectorXd& u, double mean) const {
  const double pooled = std::pow(noise.at(mean), 2);
  return local_noise.uniform()
             ? widened_variance(pooled, noise.degrees_of_freedom)
             : widened_variance(local_noise.factor(u) * pooled, local_noise.freedom(u));
}

double NoiseModel::at(double level) const {
  return std::sqrt((1 - relative_probability) * constant_sd * constant_sd +
                   relative_probability * std::pow(relative_sd * level, 2));
}

std::optional<NoiseModel> pool_noise(const std::vector<Sample>& samples) {
  NoiseModel noise;
  bool positive = true;
  for (const Sample& s : samples)
    if (s.count >= 2) {
      noise.degrees_of_freedom += s.count - 1;
      positive = positive && s.mean > 0;
    }
  if (noise.degrees_of_freedom == 0) return std::nullopt;
  noise.constant_sd = pooled_sd(samples, false, noise.degrees_of_freedom);
  if (!positive || noise.constant_sd == 0) return noise;
  noise.relative_sd = pooled_sd(samples, true, noise.degrees_of_freedom);
  const double gain = log_likelihood(samples, true, noise.relative_sd) -
                      log_likelihood(samples, false, noise.constant_sd);
  noise.relative_probability = 1 / (1 + std::exp(-gain));
  return noise;
}

std::optional<NoiseModel> pool_noise(const std::vector<Sample>& samples,
                                     const std::vector<Sample>& others) {
  constexpr double significance = 0.01;
  const auto alone = pool_noise(samples);
  if (others.empty()) return alone;
  std::vector<Sample> all = samples;
  all.insert(all.end(), others.begin(), others.end());
  const auto together = pool_noise(all);
  if (!alone || !together) return together;
  const int freedom = alone->degrees_of_freedom, more = together->degrees_of_freedom - freedom;
  if (more == 0) return alone;
  const double own = pooled_sd(samples, together->is_relative(), freedom),
               other = pooled_sd(others, together->is_relative(), more);
  if (!(own > 0) || !(other > 0)) return own == other ? together : alone;
  const double ratio = std::pow(own / other, 2);
  if (!std::isfinite(ratio)) return alone;
  const double below = boost::math::cdf(boost::math::fisher_f(freedom, more), ratio);
  return 2 * std::min(below, 1 - below) < significance ? alone : together;
}

OutcomeProbability::OutcomeProbability(const std::vector<Point>& points, std::size_t experiment,
                                       const std::vector<JobStatus>& counted,
                                       const std::vector<JobStatus>& among) {
  for (const Point& p : points) {
    u_.push_back(p.u);
    counted_.push_back(0);
    for (const JobStatus status : counted) counted_.back() += p.count(status, experiment);
    runs_.push_back(counted_.back());
    for (const JobStatus status : among) runs_.back() += p.count(status, experiment);
    any_ = any_ || counted_.back() > 0;
  }
}

double OutcomeProbability::at(const VectorXd& u) const {
  if (!any_) return 0;
  double counted = 0, runs = share_prior_runs;
  for (std::size_t i = 0; i < u_.size(); ++i) {
    const double w = std::exp(-0.5 * (u - u_[i]).squaredNorm() / (share_reach * share_reach));
    counted += w * counted_[i];
    runs += w * runs_[i];
  }
  return counted / runs;
}

namespace {

double any_of(const std::vector<OutcomeProbability>& shares, const VectorXd& u) {
  double none = 1;
  for (const OutcomeProbability& share : shares) none *= 1 - share.at(u);
  return 1 - none;
}

}  // namespace

double ResponseModels::arch_probability(const VectorXd& u) const { return any_of(arched, u); }
double ResponseModels::cut_short_probability(const VectorXd& u) const {
  return any_of(cut_short, u);
}

std::optional<ResponseModels> fit_response_models(const Study& study,
                                                  const std::vector<Point>& points,
                                                  const std::vector<Point>& elsewhere) {
  using enum JobStatus;
  ResponseModels k;
  for (std::size_t e = 0; e < study.experiments.size(); ++e) {
    k.arched.emplace_back(points, e, std::vector{JobStatus::arched}, std::vector{finished});
    k.cut_short.emplace_back(points, e, std::vector{failed, crashed, timed_out, out_of_memory},
                             std::vector{finished, JobStatus::arched});
  }
  for (const Target& t : study.targets) {
    auto m = fit_response_model(t.response, points, elsewhere);
    if (!m) return std::nullopt;
    k.targets.push_back(std::move(*m));
  }
  for (const Observed& o : study.observed)
    if (auto m = fit_response_model(o.response, points, elsewhere))
      k.observed.push_back(std::move(*m));
  return k;
}

double NegativeLogPosterior::cost(const VectorXd& u) const {
  double sum = 0;
  for (std::size_t k = 0; k < study_.targets.size(); ++k) {
    const Target& t = study_.targets[k];
    const Prediction p = models_.targets[k].surrogate.best.predict(u);
    const double v = t.variance() + p.variance;
    sum += (p.mean - t.value) * (p.mean - t.value) / v + std::log(v);
  }
  sum += prior_cost(study_.priors, study_.parameters, u);
  if (!study_.constraints.all.empty())
    sum += violations(study_.constraints, study_.parameters, u).squaredNorm();
  return sum - 2 * std::log(1 - models_.arch_probability(u));
}

double NegativeLogPosterior::regularized_cost(const VectorXd& u) const {
  return cost(u) + (u.array() - 0.5).square().sum() / (pull_sd * pull_sd);
}

VectorXd NegativeLogPosterior::z(const VectorXd& u) const {
  VectorXd z(static_cast<Index>(study_.targets.size()));
  for (Index k = 0; k < z.size(); ++k) {
    const Target& t = study_.targets[static_cast<std::size_t>(k)];
    const Prediction p = models_.targets[static_cast<std::size_t>(k)].surrogate.best.predict(u);
    z[k] = (p.mean - t.value) / std::sqrt(t.variance() + p.variance);
  }
  return z;
}

LeastSquaresProblem NegativeLogPosterior::residuals(const VectorXd& frozen) const {
  const Index targets = static_cast<Index>(study_.targets.size()), d = dimensions();
  VectorXd sd(targets);
  for (Index k = 0; k < targets; ++k) {
    const auto i = static_cast<std::size_t>(k);
    sd[k] = std::hypot(study_.targets[i].sd(),
                       std::sqrt(models_.targets[i].surrogate.best.predict(frozen).variance));
  }
  LeastSquaresProblem problem;
  Index beliefs = static_cast<Index>(study_.constraints.all.size());
  for (const Prior& prior : study_.priors) beliefs += prior.residuals();
  problem.residuals = static_cast<int>(targets + 2 * d + beliefs);
  problem.lower = VectorXd::Zero(d);
  problem.upper = VectorXd::Ones(d);
  problem.evaluate = [this, sd, targets, d](const VectorXd& u, VectorXd& r, MatrixXd* jacobian) {
    r.setZero();
    if (jacobian != nullptr) jacobian->setZero();
    for (Index k = 0; k < targets; ++k) {
      const auto i = static_cast<std::size_t>(k);
      const Prediction p = models_.targets[i].surrogate.best.predict_with_gradients(u);
      r[k] = (p.mean - study_.targets[i].value) / sd[k];
      if (jacobian != nullptr) jacobian->row(k) = p.mean_gradient.transpose() / sd[k];
    }
    for (Index i = 0; i < d; ++i) {
      const Parameter& p = study_.parameters[static_cast<std::size_t>(i)];
      if (const auto prior = p.prior_sd_unit()) {
        r[targets + i] = (u[i] - p.prior_mean_unit()) / *prior;
        if (jacobian != nullptr) (*jacobian)(targets + i, i) = 1 / *prior;
      }
      r[targets + d + i] = (u[i] - 0.5) / pull_sd;
      if (jacobian != nullptr) (*jacobian)(targets + d + i, i) = 1 / pull_sd;
    }
    Index row = targets + 2 * d;
    const auto append = [&](const VectorXd& more, const MatrixXd& slopes) {
      r.segment(row, more.size()) = more;
      if (jacobian != nullptr) jacobian->middleRows(row, more.size()) = slopes;
      row += more.size();
    };
    VectorXd more;
    MatrixXd slopes;
    for (const Prior& prior : study_.priors) {
      prior_residuals(prior, study_.parameters, u, more, slopes);
      append(more, slopes);
    }
    more = violations(study_.constraints, study_.parameters, u, &slopes);
    append(more, slopes);
    return true;
  };
  return problem;
}

Minimum NegativeLogPosterior::best() const {
  const VectorXd zero = VectorXd::Zero(dimensions()), one = VectorXd::Ones(dimensions());
  const auto f = [this](const VectorXd& u) { return regularized_cost(u); };
  Minimum m = minimize(f, zero, one, search_evaluations);
  // Least squares omits ln V and arching: its result is used only where its cost is not larger.
  const LeastSquaresFit fit = least_squares(residuals(m.x), m.x);
  if (const double value = fit.x.allFinite() ? regularized_cost(fit.x) : m.value; value < m.value) {
    m.x = fit.x;
    m.value = value;
  }
  return m;
}

}  // namespace firn
