#include "calibrate/identify.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "calibrate/design.h"

namespace firn {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// A uniform range has this standard deviation; a direction is identified when the data alone do
// better than that.
const double uniform_sd = 1 / std::sqrt(12.0);
constexpr int samples_per_dimension = 4096;
constexpr double enough_samples = 400;
constexpr int valley_members = 5;
constexpr int candidates = 400;
constexpr double keep_apart = 0.15;  // unit cube

VarianceSplit split_variance(const Target& t, const Prediction& p) {
  return {t.uncertainty * t.uncertainty, p.noise_variance, p.variance - p.noise_variance};
}

// Standard deviation of what was believed of a parameter before any run.
double prior_sd(const Parameter& p) {
  const auto sd = p.prior_sd_unit();
  if (!sd) return uniform_sd;
  constexpr int cells = 1000;
  double w0 = 0, w1 = 0, w2 = 0;
  for (int i = 0; i < cells; ++i) {
    const double x = (i + 0.5) / cells, z = (x - p.prior_mean_unit()) / *sd;
    const double w = std::exp(-0.5 * z * z);
    w0 += w;
    w1 += w * x;
    w2 += w * x * x;
  }
  return std::sqrt(w2 / w0 - (w1 / w0) * (w1 / w0));
}

// x such that a fraction q of the weight lies at or below it.
double weighted_quantile(const std::vector<double>& x, const std::vector<double>& weight,
                         double q) {
  std::vector<std::size_t> order(x.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return x[a] < x[b]; });
  double sum = 0;
  for (const std::size_t i : order) {
    sum += weight[i];
    if (sum >= q) return x[i];
  }
  return x[order.back()];
}

// Samples the box [lower, upper] of the cube and weighs each point by its cost.
void weigh(const Misfit& misfit, const VectorXd& lower, const VectorXd& upper, Posterior& p) {
  const int d = static_cast<int>(lower.size()), count = samples_per_dimension * d;
  std::vector<double> cost(static_cast<std::size_t>(count));
  p.u.resize(cost.size());
  p.weight.resize(cost.size());
  for (std::size_t i = 0; i < cost.size(); ++i) {
    p.u[i] = lower + quasi_random_point(i, d).cwiseProduct(upper - lower);
    cost[i] = misfit.cost(p.u[i]);
  }
  const double least = *std::min_element(cost.begin(), cost.end());
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < cost.size(); ++i)
    sum += p.weight[i] = std::exp(-0.5 * (cost[i] - least));
  for (double& w : p.weight) {
    w /= sum;
    squares += w * w;
  }
  p.effective_samples = 1 / squares;
}

Marginal marginal(const Parameter& parameter, const Posterior& p, Index i) {
  Marginal m;
  std::vector<double> x(p.u.size());
  for (std::size_t s = 0; s < x.size(); ++s) {
    x[s] = p.u[s][i];
    m.mean += p.weight[s] * x[s];
  }
  for (std::size_t s = 0; s < x.size(); ++s)
    m.sd += p.weight[s] * (x[s] - m.mean) * (x[s] - m.mean);
  m.sd = std::sqrt(m.sd);
  const double low = weighted_quantile(x, p.weight, 0.025);
  const double high = weighted_quantile(x, p.weight, 0.975);
  m.low = parameter.from_unit(low);
  m.median = parameter.from_unit(weighted_quantile(x, p.weight, 0.5));
  m.high = parameter.from_unit(high);
  m.width_ratio = m.sd / prior_sd(parameter);
  constexpr double at_end = 0.03;  // a flat density would leave 2.5 % below
  m.at_min = low < at_end;
  m.at_max = high > 1 - at_end;
  return m;
}

}  // namespace

std::vector<Combination> combinations(const Study& study, const Knowledge& knowledge,
                                      const VectorXd& u) {
  const Index targets = static_cast<Index>(study.targets.size()), d = u.size();
  MatrixXd jacobian(targets, d);
  std::vector<VarianceSplit> splits;
  for (Index k = 0; k < targets; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const Prediction p = knowledge.targets[i].surrogate.best.predict(u);
    splits.push_back(split_variance(study.targets[i], p));
    jacobian.row(k) = p.mean_gradient.transpose() / std::sqrt(splits.back().total());
  }
  const Eigen::JacobiSVD<MatrixXd> svd(jacobian, Eigen::ComputeFullU | Eigen::ComputeFullV);
  std::vector<Combination> all;
  for (Index j = 0; j < d; ++j) {
    Combination c;
    c.direction = svd.matrixV().col(j);
    c.singular_value = j < svd.singularValues().size() ? svd.singularValues()[j] : 0;
    c.identified = c.singular_value * uniform_sd > 1;
    // From the unit cube to the parameters or their logarithms, at unit length.
    c.coefficients = c.direction;
    for (Index i = 0; i < d; ++i)
      c.coefficients[i] /= study.parameters[static_cast<std::size_t>(i)].width();
    Index largest = 0;
    c.coefficients.cwiseAbs().maxCoeff(&largest);
    const double norm = (c.coefficients[largest] < 0 ? -1 : 1) * c.coefficients.norm();
    c.coefficients /= norm;
    c.direction *= norm < 0 ? -1 : 1;
    for (Index i = 0; i < d; ++i) {
      const Parameter& p = study.parameters[static_cast<std::size_t>(i)];
      const double x = p.from_unit(u[i]);
      c.value += c.coefficients[i] * (p.logarithmic ? std::log(x) : x);
    }
    c.sd = c.singular_value > 0 ? 1 / (c.singular_value * std::abs(norm))
                                : std::numeric_limits<double>::infinity();
    if (c.identified)
      for (Index k = 0; k < targets; ++k) {
        // Each target's share in this direction, times where its variance comes from.
        const VarianceSplit& s = splits[static_cast<std::size_t>(k)];
        const double share = c.sd * c.sd * svd.matrixU()(k, j) * svd.matrixU()(k, j) / s.total();
        c.split.measurement += share * s.measurement;
        c.split.seeds += share * s.seeds;
        c.split.surrogate += share * s.surrogate;
      }
    all.push_back(std::move(c));
  }
  return all;
}

Posterior sample_posterior(const Study& study, const Misfit& misfit) {
  const Index d = static_cast<Index>(study.parameters.size());
  Posterior p;
  VectorXd lower = VectorXd::Zero(d), upper = VectorXd::Ones(d);
  weigh(misfit, lower, upper, p);
  // Too few samples carry weight: look closer at the part of the cube that does.
  for (int round = 0; round < 4 && p.effective_samples < enough_samples; ++round) {
    VectorXd first = upper, last = lower;
    const double most = *std::max_element(p.weight.begin(), p.weight.end());
    for (std::size_t s = 0; s < p.u.size(); ++s)
      if (p.weight[s] > 1e-5 * most) {
        first = first.cwiseMin(p.u[s]);
        last = last.cwiseMax(p.u[s]);
      }
    const VectorXd margin = 0.25 * (last - first).array() + 0.02 * (upper - lower).array();
    const VectorXd zero = VectorXd::Zero(d), one = VectorXd::Ones(d);
    lower = (first - margin).cwiseMax(zero);
    upper = (last + margin).cwiseMin(one);
    weigh(misfit, lower, upper, p);
  }
  VectorXd mean = VectorXd::Zero(d);
  MatrixXd covariance = MatrixXd::Zero(d, d);
  for (std::size_t s = 0; s < p.u.size(); ++s) mean += p.weight[s] * p.u[s];
  for (std::size_t s = 0; s < p.u.size(); ++s)
    covariance += p.weight[s] * (p.u[s] - mean) * (p.u[s] - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(covariance);
  p.longest = eigen.eigenvectors().col(d - 1);
  if (p.longest[0] < 0) p.longest *= -1;
  for (Index i = 0; i < d; ++i)
    p.marginals.push_back(marginal(study.parameters[static_cast<std::size_t>(i)], p, i));
  return p;
}

std::vector<ValleyMember> valley(const Study& study, const Misfit& misfit,
                                 const Posterior& posterior) {
  const Index d = posterior.longest.size();
  std::vector<double> along(posterior.u.size());
  for (std::size_t s = 0; s < along.size(); ++s) along[s] = posterior.longest.dot(posterior.u[s]);
  std::vector<ValleyMember> members;
  for (int m = 0; m < valley_members; ++m) {
    const double q = 0.05 + 0.9 * m / (valley_members - 1);
    const double place = weighted_quantile(along, posterior.weight, q);
    // The best answer on the plane across the valley at this place, the plane made soft.
    const auto f = [&](const VectorXd& u) {
      return misfit.cost(u) + std::pow((posterior.longest.dot(u) - place) / 0.01, 2);
    };
    std::size_t start = 0;
    for (std::size_t s = 1; s < along.size(); ++s)
      if (std::abs(along[s] - place) < 0.02 &&
          (std::abs(along[start] - place) >= 0.02 || posterior.weight[s] > posterior.weight[start]))
        start = s;
    const Minimum best =
        minimize_locally(f, VectorXd::Zero(d), VectorXd::Ones(d), posterior.u[start], 0.02, 400);
    members.push_back({best.x, tidy_values(study.parameters, best.x)});
  }
  return members;
}

std::vector<VectorXd> splitting_points(const Study& study, const Knowledge& knowledge,
                                       const Posterior& posterior, std::vector<VectorXd> taken,
                                       int count) {
  // Systematic resampling: candidates are as dense as the posterior.
  std::vector<VectorXd> pool;
  double sum = 0;
  for (std::size_t s = 0; s < posterior.u.size(); ++s) {
    sum += posterior.weight[s];
    if (sum > (static_cast<double>(pool.size()) + 0.5) / candidates) pool.push_back(posterior.u[s]);
  }
  std::vector<Surrogate> believed;
  for (const ResponseModel& m : knowledge.targets) believed.push_back(m.surrogate.best);
  std::vector<VectorXd> chosen;
  for (int i = 0; i < count; ++i) {
    const VectorXd* best = nullptr;
    double most = -1;
    for (const VectorXd& u : pool) {
      double score = 0;
      for (std::size_t k = 0; k < believed.size(); ++k)
        score += believed[k].predict(u).variance / std::pow(study.targets[k].uncertainty, 2);
      score *= std::pow(1 - knowledge.arch.probability(u), 2);
      // A polynomial's variance hardly knows where the points are: keep them apart ourselves.
      for (const VectorXd& t : taken)
        score *= 1 - std::exp(-0.5 * (u - t).squaredNorm() / (keep_apart * keep_apart));
      if (score > most) {
        most = score;
        best = &u;
      }
    }
    chosen.push_back(*best);
    taken.push_back(*best);
    for (std::size_t k = 0; k < believed.size(); ++k) {
      const double level = believed[k].predict(*best).mean;
      const double noise = knowledge.targets[k].noise.at(level);
      believed[k] =
          believed[k].with_believed_point(*best, noise * noise / study.budget.runs_per_point);
    }
  }
  return chosen;
}

}  // namespace firn
