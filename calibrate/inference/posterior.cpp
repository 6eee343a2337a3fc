#include "calibrate/inference/posterior.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <random>
#include <stdexcept>
#include <utility>

#include "calibrate/numerics/experimental_design.h"
#include "experiments/analysis/random_stream.h"
#include "experiments/analysis/sample_statistics.h"

namespace firn {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t cloud_size = 4096;
constexpr std::uint64_t most_tries = 10000 * cloud_size;
constexpr int moves = 6;  // Metropolis steps of every sample at each temperature
constexpr int profile_points = 25;
constexpr double wilks_95 = 3.841;  // quantile of chi squared with one degree of freedom

VectorXd normal_vector(std::mt19937_64& random, Index d) {
  VectorXd v(d);
  for (Index i = 0; i < d; ++i) v[i] = normal_deviate(random);
  return v;
}

double effective(const std::vector<double>& weight) {
  double sum = 0, squares = 0;
  for (const double w : weight) {
    sum += w;
    squares += w * w;
  }
  return sum * sum / squares;
}

// exp(-(to - from) / 2 * cost), the largest being 1.
std::vector<double> tempered_weights(const std::vector<double>& cost, double step) {
  const double least = *std::min_element(cost.begin(), cost.end());
  std::vector<double> weight;
  weight.reserve(cost.size());
  for (const double c : cost) weight.push_back(std::exp(-0.5 * step * (c - least)));
  return weight;
}

// Logarithm of the mean of exp(-step / 2 * cost), by its weights relative to the largest.
double log_mean_weight(const std::vector<double>& cost, const std::vector<double>& weight,
                       double step) {
  const double sum = std::accumulate(weight.begin(), weight.end(), 0.0);
  return std::log(sum / static_cast<double>(weight.size())) -
         0.5 * step * *std::min_element(cost.begin(), cost.end());
}

// The longest step of the temperature after which half of the cloud still counts.
double longest_step(const std::vector<double>& cost, double left) {
  const double enough = 0.5 * static_cast<double>(cost.size());
  if (effective(tempered_weights(cost, left)) >= enough) return left;
  double low = 0, high = left;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (effective(tempered_weights(cost, middle)) >= enough ? low : high) = middle;
  }
  return low > 0 ? low : high;
}

MatrixXd covariance(const std::vector<VectorXd>& u, const std::vector<double>& weight) {
  const Index d = u.front().size();
  VectorXd mean = VectorXd::Zero(d);
  MatrixXd c = MatrixXd::Zero(d, d);
  for (std::size_t s = 0; s < u.size(); ++s) mean += weight[s] * u[s];
  for (std::size_t s = 0; s < u.size(); ++s)
    c += weight[s] * (u[s] - mean) * (u[s] - mean).transpose();
  return c;
}

class Cloud {
 public:
  Cloud(const std::function<double(const VectorXd&)>& density_cost, int dimensions)
      : cost_of_(density_cost), random_(20061) {
    // Places without density are left out, so that the cloud begins with its full size.
    for (std::uint64_t i = 0; u.size() < cloud_size; ++i) {
      if (i == most_tries)
        throw std::logic_error("the posterior has no density at any of its candidates");
      const VectorXd place = quasi_random_point(i, dimensions);
      const double there = cost_of_(place);
      if (there == std::numeric_limits<double>::infinity()) continue;
      u.push_back(place);
      cost.push_back(there);
    }
  }

  // The number of copies of each sample is proportional to its weight; equal weights afterwards.
  void resample(const std::vector<double>& weight) {
    const double sum = std::accumulate(weight.begin(), weight.end(), 0.0);
    std::vector<VectorXd> chosen;
    std::vector<double> its_cost;
    double reached = 0;
    for (std::size_t s = 0; s < u.size(); ++s) {
      reached += weight[s] / sum * static_cast<double>(u.size());
      while (static_cast<double>(chosen.size()) + 0.5 < reached) {
        chosen.push_back(u[s]);
        its_cost.push_back(cost[s]);
      }
    }
    while (chosen.size() < u.size()) {  // what rounding left
      chosen.push_back(chosen.back());
      its_cost.push_back(its_cost.back());
    }
    u = std::move(chosen);
    cost = std::move(its_cost);
  }

  // Metropolis steps under exp(-temperature / 2 * cost) inside the cube.
  void move(double temperature) {
    const Index d = u.front().size();
    const std::vector<double> equal(u.size(), 1.0 / static_cast<double>(u.size()));
    MatrixXd c = covariance(u, equal);
    c.diagonal().array() += 1e-12;
    const MatrixXd factor = c.llt().matrixL();
    double length = 2.38 / std::sqrt(static_cast<double>(d));
    for (int m = 0; m < moves; ++m) {
      int accepted = 0;
      for (std::size_t s = 0; s < u.size(); ++s) {
        const VectorXd v = u[s] + length * (factor * normal_vector(random_, d));
        const double chance = uniform_open(random_);
        if (v.minCoeff() < 0 || v.maxCoeff() > 1) continue;
        const double there = cost_of_(v);
        if (!(0.5 * temperature * (there - cost[s]) < -std::log(chance))) continue;
        u[s] = v;
        cost[s] = there;
        ++accepted;
      }
      // A curved ridge needs shorter steps than a Gaussian of the same covariance.
      const double rate = accepted / static_cast<double>(u.size());
      length *= std::exp(std::clamp(rate - 0.25, -0.5, 0.5));
    }
  }

  std::vector<VectorXd> u;
  std::vector<double> cost;

 private:
  const std::function<double(const VectorXd&)>& cost_of_;
  std::mt19937_64 random_;
};

constexpr double end_part = 0.02;  // fraction of a range that counts as its end

// Ends of a parameter's range inside its 95 % profile-likelihood interval, judged by the samples
// there.
struct PossibleEnds {
  bool at_min = false, at_max = false;
};

PossibleEnds possible_ends(const Posterior& p, Index i) {
  double least = p.cost.front(), at_low = std::numeric_limits<double>::infinity(), at_high = at_low;
  for (std::size_t s = 0; s < p.u.size(); ++s) {
    least = std::min(least, p.cost[s]);
    if (p.u[s][i] < end_part) at_low = std::min(at_low, p.cost[s]);
    if (p.u[s][i] > 1 - end_part) at_high = std::min(at_high, p.cost[s]);
  }
  return {at_low - least <= wilks_95, at_high - least <= wilks_95};
}

// Central 95 % of parameter i where parameter j is at an end of its range.
std::optional<std::pair<double, double>> interval_at_end(const Posterior& p, Index i, Index j,
                                                         bool at_max) {
  constexpr std::size_t fewest = 40;
  std::vector<double> x, weight;
  double sum = 0;
  for (std::size_t s = 0; s < p.u.size(); ++s) {
    if (at_max ? p.u[s][j] < 1 - end_part : p.u[s][j] > end_part) continue;
    x.push_back(p.u[s][i]);
    weight.push_back(p.weight[s]);
    sum += p.weight[s];
  }
  if (x.size() < fewest) return std::nullopt;
  for (double& w : weight) w /= sum;
  return std::pair(weighted_quantile(x, weight, 0.025), weighted_quantile(x, weight, 0.975));
}

Marginal marginal(const Study& study, const Posterior& p, const std::vector<PossibleEnds>& ends,
                  Index i) {
  const auto index = static_cast<std::size_t>(i);
  const Parameter& parameter = study.parameters[index];
  Marginal m;
  std::vector<double> x(p.u.size());
  for (std::size_t s = 0; s < x.size(); ++s) {
    x[s] = p.u[s][i];
    m.mean += p.weight[s] * x[s];
  }
  for (std::size_t s = 0; s < x.size(); ++s)
    m.sd += p.weight[s] * (x[s] - m.mean) * (x[s] - m.mean);
  m.sd = std::sqrt(m.sd);
  // A central interval never contains an end of the range: one-sided intervals are used there.
  m.at_min = ends[index].at_min;
  m.at_max = ends[index].at_max;
  double low = m.at_min ? 0 : weighted_quantile(x, p.weight, m.at_max ? 0.05 : 0.025);
  double high = m.at_max ? 1 : weighted_quantile(x, p.weight, m.at_min ? 0.95 : 0.975);
  // On a ridge, this parameter is at the end of its marginal where another one is at the end of its
  // range. The interval is widened to include these samples.
  for (Index other = 0; other < p.u.front().size(); ++other) {
    if (other == i) continue;
    const PossibleEnds& of = ends[static_cast<std::size_t>(other)];
    for (const bool at_max : {false, true}) {
      if (!(at_max ? of.at_max : of.at_min)) continue;
      if (const auto there = interval_at_end(p, i, other, at_max)) {
        low = std::min(low, there->first);
        high = std::max(high, there->second);
      }
    }
  }
  m.low = m.at_min ? parameter.min : parameter.from_unit(low);
  m.median = parameter.from_unit(weighted_quantile(x, p.weight, 0.5));
  m.high = m.at_max ? parameter.max : parameter.from_unit(high);
  m.low_68 = parameter.from_unit(weighted_quantile(x, p.weight, 0.16));
  m.high_68 = parameter.from_unit(weighted_quantile(x, p.weight, 0.84));
  const bool believed = prior_count(study.priors, study.parameters) > 0;
  m.posterior_to_prior_sd =
      m.sd / (believed ? prior_sd(study.priors, study.parameters, index) : 1 / std::sqrt(12.0));
  return m;
}

// The least cost with parameter i held, found from `start`; the others end up in it.
double least_with(const NegativeLogPosterior& misfit, Index i, double held, VectorXd& start) {
  const Index d = start.size();
  start[i] = held;
  if (d == 1) return misfit.cost(start);
  const auto whole = [&](const VectorXd& others) {
    VectorXd u(d);
    u << others.head(i), held, others.tail(d - 1 - i);
    return u;
  };
  VectorXd others(d - 1);
  others << start.head(i), start.tail(d - 1 - i);
  const Minimum m =
      minimize_locally([&](const VectorXd& v) { return misfit.cost(whole(v)); },
                       VectorXd::Zero(d - 1), VectorXd::Ones(d - 1), others, 0.1, 200);
  start = whole(m.x);
  return m.value;
}

// Where a profile crosses `level` on its way from point k to the side `step`, own unit.
double crossing(const Parameter& parameter, const Profile& p, std::size_t k, int step,
                double level) {
  const auto last = static_cast<std::size_t>(step < 0 ? 0 : profile_points - 1);
  while (k != last) {
    const std::size_t next = step < 0 ? k - 1 : k + 1;
    if (p.cost[next] > level) {
      const double part = (level - p.cost[k]) / (p.cost[next] - p.cost[k]);
      return parameter.from_unit(p.u[k] + part * (p.u[next] - p.u[k]));
    }
    k = next;
  }
  return parameter.from_unit(p.u[last]);
}

}  // namespace

double Posterior::hpd_level(double place_cost) const {
  double sum = 0;
  for (std::size_t s = 0; s < cost.size(); ++s)
    if (cost[s] < place_cost) sum += weight[s];
  return sum;
}

Posterior sample_density(const std::function<double(const VectorXd&)>& cost, int dimensions) {
  Cloud cloud(cost, dimensions);
  double temperature = 0, log_evidence = 0;
  std::vector<double> weight;
  while (true) {
    const double step = longest_step(cloud.cost, 1 - temperature);
    weight = tempered_weights(cloud.cost, step);
    log_evidence += log_mean_weight(cloud.cost, weight, step);
    if (temperature + step >= 1) break;
    temperature += step;
    cloud.resample(weight);
    cloud.move(temperature);
  }
  Posterior p;
  const double sum = std::accumulate(weight.begin(), weight.end(), 0.0);
  for (double& w : weight) w /= sum;
  p.log_evidence = log_evidence;
  p.effective_samples = effective(weight);
  p.u = std::move(cloud.u);
  p.cost = std::move(cloud.cost);
  p.weight = std::move(weight);
  p.hpd_95_cost = weighted_quantile(p.cost, p.weight, 0.95);
  return p;
}

Posterior sample_posterior(const Study& study, const NegativeLogPosterior& misfit) {
  const Index d = static_cast<Index>(study.parameters.size());
  Posterior p = sample_density(
      [&](const VectorXd& u) {
        return allowed(study.constraints, study.parameters, u)
                   ? misfit.cost(u)
                   : std::numeric_limits<double>::infinity();
      },
      static_cast<int>(d));
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(covariance(p.u, p.weight));
  p.longest = eigen.eigenvectors().col(d - 1);
  if (p.longest[0] < 0) p.longest *= -1;
  std::vector<PossibleEnds> ends;
  for (Index i = 0; i < d; ++i) ends.push_back(possible_ends(p, i));
  for (Index i = 0; i < d; ++i) p.marginals.push_back(marginal(study, p, ends, i));
  return p;
}

std::vector<VectorXd> resampled(const Posterior& p, std::size_t count) {
  std::vector<VectorXd> chosen;
  double sum = 0;
  for (std::size_t s = 0; s < p.u.size(); ++s) {
    sum += p.weight[s];
    while (chosen.size() < count &&
           sum > (static_cast<double>(chosen.size()) + 0.5) / static_cast<double>(count))
      chosen.push_back(p.u[s]);
  }
  return chosen;
}

std::vector<Profile> profile_likelihoods(const Study& study, const NegativeLogPosterior& misfit,
                                         const Posterior& posterior) {
  const Index d = static_cast<Index>(study.parameters.size());
  std::vector<Profile> all;
  for (Index i = 0; i < d; ++i) {
    Profile p;
    for (int k = 0; k < profile_points; ++k) {
      const double held = static_cast<double>(k) / (profile_points - 1);
      // From the sample nearest in cost, a step along the range counting like one sd of the data.
      std::size_t nearest = 0;
      double least = std::numeric_limits<double>::infinity();
      for (std::size_t s = 0; s < posterior.u.size(); ++s) {
        const double far = (posterior.u[s][i] - held) * profile_points;
        if (const double c = posterior.cost[s] + far * far; c < least) {
          least = c;
          nearest = s;
        }
      }
      VectorXd start = posterior.u[nearest];
      p.u.push_back(held);
      p.cost.push_back(least_with(misfit, i, held, start));
    }
    const auto lowest = std::min_element(p.cost.begin(), p.cost.end());
    const auto k = static_cast<std::size_t>(lowest - p.cost.begin());
    const double floor =
        std::min(*lowest, *std::min_element(posterior.cost.begin(), posterior.cost.end()));
    for (double& c : p.cost) c -= floor;
    const Parameter& parameter = study.parameters[static_cast<std::size_t>(i)];
    p.low = crossing(parameter, p, k, -1, wilks_95);
    p.high = crossing(parameter, p, k, 1, wilks_95);
    all.push_back(std::move(p));
  }
  return all;
}

}  // namespace firn
