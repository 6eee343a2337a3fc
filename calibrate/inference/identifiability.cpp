#include "calibrate/inference/identifiability.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calibrate/numerics/experimental_design.h"
#include "experiments/analysis/sample_statistics.h"

namespace firn {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// A uniform range has this standard deviation; a direction is identified when the data alone do
// better than that.
const double uniform_sd = 1 / std::sqrt(12.0);
constexpr int ridge_members = 5;
constexpr std::size_t candidates = 400;
constexpr double keep_apart = 0.15;  // unit cube

VarianceSplit split_variance(const Target& t, const Prediction& p, VarianceSources sources) {
  const double measurement = t.uncertainty * t.uncertainty;
  const double discrepancy = t.discrepancy * t.discrepancy;
  if (sources == VarianceSources::measurement) return {measurement, 0, 0, discrepancy};
  return {measurement, p.noise_variance, p.variance - p.noise_variance, discrepancy};
}

double value_at(const Study& study, const Combination& c, const VectorXd& u) {
  double value = 0;
  for (Index i = 0; i < u.size(); ++i) {
    const Parameter& p = study.parameters[static_cast<std::size_t>(i)];
    const double x = p.from_unit(u[i]);
    value += c.coefficients[i] * p.scaled(x);
  }
  return value;
}

// True where the model's uncertainty at u is not negligible compared with a target's.
bool unsure(const Study& study, const std::vector<Surrogate>& models, const VectorXd& u) {
  constexpr double counts = 0.3;
  for (std::size_t k = 0; k < models.size(); ++k)
    if (std::sqrt(models[k].predict(u).variance) > counts * study.targets[k].sd()) return true;
  return false;
}

}  // namespace

std::vector<Combination> combinations(const Study& study, const ResponseModels& models,
                                      const VectorXd& u, VarianceSources sources) {
  const Index targets = static_cast<Index>(study.targets.size()), d = u.size();
  MatrixXd jacobian(targets, d);
  std::vector<VarianceSplit> splits;
  for (Index k = 0; k < targets; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const Prediction p = models.targets[i].surrogate.best.predict_with_gradients(u);
    splits.push_back(split_variance(study.targets[i], p, sources));
    jacobian.row(k) = p.mean_gradient.transpose() / std::sqrt(splits.back().total());
  }
  const Eigen::JacobiSVD<MatrixXd> svd(jacobian, Eigen::ComputeFullU | Eigen::ComputeFullV);
  std::vector<Combination> all;
  for (Index j = 0; j < d; ++j) {
    Combination c;
    c.direction = svd.matrixV().col(j);
    c.singular_value = j < svd.singularValues().size() ? svd.singularValues()[j] : 0;
    c.identifiable = c.singular_value * uniform_sd > 1;
    // From the unit cube to the parameters or their logarithms, at unit length.
    c.coefficients = c.direction;
    for (Index i = 0; i < d; ++i)
      c.coefficients[i] /= study.parameters[static_cast<std::size_t>(i)].width();
    Index largest = 0;
    c.coefficients.cwiseAbs().maxCoeff(&largest);
    const double norm = (c.coefficients[largest] < 0 ? -1 : 1) * c.coefficients.norm();
    c.coefficients /= norm;
    c.direction *= norm < 0 ? -1 : 1;
    c.value = value_at(study, c, u);
    c.sd = c.singular_value > 0 ? 1 / (c.singular_value * std::abs(norm))
                                : std::numeric_limits<double>::infinity();
    if (c.identifiable)
      for (Index k = 0; k < targets; ++k) {
        // Each target's share in this direction, times where its variance comes from.
        const VarianceSplit& s = splits[static_cast<std::size_t>(k)];
        const double share = c.sd * c.sd * svd.matrixU()(k, j) * svd.matrixU()(k, j) / s.total();
        c.split.measurement += share * s.measurement;
        c.split.seeds += share * s.seeds;
        c.split.surrogate += share * s.surrogate;
        c.split.discrepancy += share * s.discrepancy;
      }
    all.push_back(std::move(c));
  }
  return all;
}

void rms_over_posterior(const Posterior& posterior, const Study& study,
                        std::vector<Combination>& all) {
  for (Combination& c : all) {
    double squares = 0;
    std::vector<double> distances;
    for (std::size_t s = 0; s < posterior.u.size(); ++s) {
      distances.push_back(std::abs(value_at(study, c, posterior.u[s]) - c.value));
      squares += posterior.weight[s] * distances.back() * distances.back();
    }
    c.spread = std::sqrt(squares);
    c.distance_95 = weighted_quantile(distances, posterior.weight, 0.95);
    if (!c.is_curved()) continue;
    // The ends of a curved ridge are far from its direction and hold little of the posterior.
    for (std::size_t s = 0; s < distances.size(); ++s)
      if (posterior.cost[s] <= posterior.hpd_95_cost)
        c.distance_95 = std::max(c.distance_95, distances[s]);
  }
}

double expected_narrowing(const Study& study, const ResponseModels& models,
                          const Posterior& posterior, const VectorXd& u) {
  const auto now = combinations(study, models, u);
  const auto then = combinations(study, models, u, VarianceSources::measurement);
  for (std::size_t j = 0; j < now.size(); ++j)
    if (then[j].identifiable && !now[j].identifiable) return 1;
  double gain = 0;
  for (std::size_t k = 0; k < study.targets.size(); ++k) {
    double variance = 0;
    for (std::size_t s = 0; s < posterior.u.size(); ++s)
      variance +=
          posterior.weight[s] * models.targets[k].surrogate.best.predict(posterior.u[s]).variance;
    const double least = study.targets[k].sd();
    gain = std::max(gain, 1 - least / std::hypot(least, std::sqrt(variance)));
  }
  return gain;
}

std::vector<RidgeMember> ridge(const Study& study, const NegativeLogPosterior& misfit,
                               const Posterior& posterior) {
  const Index d = posterior.longest.size();
  std::vector<double> along(posterior.u.size());
  for (std::size_t s = 0; s < along.size(); ++s) along[s] = posterior.longest.dot(posterior.u[s]);
  std::vector<RidgeMember> members;
  for (int m = 0; m < ridge_members; ++m) {
    const double q = 0.05 + 0.9 * m / (ridge_members - 1);
    const double place = weighted_quantile(along, posterior.weight, q);
    // The best parameter set on the plane across the ridge at this place, with a soft penalty for
    // the plane.
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
    members.push_back({best.x, allowed_values(study.constraints, study.parameters, best.x)});
  }
  return members;
}

std::vector<VectorXd> refinement_points(const Study& study, const ResponseModels& models,
                                        const Posterior& posterior, const VectorXd& estimate,
                                        FirstPoint first, std::vector<VectorXd> taken, int count,
                                        int seeds, bool low_fidelity) {
  const std::vector<VectorXd> pool = resampled(posterior, candidates);
  std::vector<Surrogate> believed;
  for (const ResponseModel& m : models.targets) believed.push_back(m.surrogate.best);
  std::vector<VectorXd> chosen;
  for (int i = 0; i < count; ++i) {
    const bool estimate_first =
        i == 0 && (first == FirstPoint::estimate || unsure(study, believed, estimate));
    const VectorXd* best = estimate_first ? &estimate : nullptr;
    double most = best != nullptr ? std::numeric_limits<double>::infinity() : -1;
    for (const VectorXd& u : pool) {
      double score = 0;
      for (std::size_t k = 0; k < believed.size(); ++k)
        score += believed[k].predict(u).variance / study.targets[k].variance();
      score *= std::pow(1 - models.arch_probability(u), 2);
      score *= 1 - models.cut_short_probability(u);  // costs as much and yields no value
      // The variance of a polynomial hardly depends on the places of the points: a minimum distance
      // keeps them apart.
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
      const double level = believed[k].predict_mean(*best);
      const double noise = models.targets[k].noise.at(level);
      believed[k] = believed[k].with_fantasy_point(*best, noise * noise / seeds, low_fidelity);
    }
  }
  return chosen;
}

}  // namespace firn
