#include "calibrate/numerics/noise_model.h"

#include <cmath>

namespace firn {
namespace {

using Eigen::VectorXd;

constexpr double clearly = 2.5;  // gain of log predictive density that makes the noise not uniform

// Logarithm of the density of a sum of squares, given a variance estimated with `freedom`, up to
// what does not depend on that estimate: Fisher's distribution.
double log_density(const NoiseSite& site, double variance, double freedom) {
  const double half = 0.5 * (site.freedom + freedom);
  return std::lgamma(half) - std::lgamma(0.5 * freedom) -
         0.5 * site.freedom * std::log(freedom * variance) -
         half * std::log1p(site.squares / (freedom * variance));
}

}  // namespace

LocalNoise::LocalNoise(std::vector<NoiseSite> sites) : sites_(std::move(sites)) {
  Sums all;
  for (const NoiseSite& s : sites_) {
    all.squares += s.squares;
    all.freedom += s.freedom;
  }
  if (sites_.size() < 3 || !(all.freedom > 2) || !(all.squares > 0)) return;
  mean_ = all.squares / all.freedom;
  double best = score(0, 0) + clearly;
  for (const double shrinkage : {1.0, 2.0, 4.0, 8.0})
    for (const double reach : {0.1, 0.2, 0.4})
      if (const double its = score(shrinkage, reach); its > best) {
        best = its;
        shrinkage_ = shrinkage;
        reach_ = reach;
      }
}

LocalNoise::Sums LocalNoise::near(const VectorXd& u, double reach, const NoiseSite* without) const {
  Sums sums;
  for (const NoiseSite& s : sites_) {
    if (&s == without) continue;
    // Without a reach, all alike.
    const double weight =
        reach > 0 ? std::exp(-0.5 * (s.u - u).squaredNorm() / (reach * reach)) : 1;
    sums.squares += weight * s.squares;
    sums.freedom += weight * s.freedom;
  }
  return sums;
}

double LocalNoise::score(double shrinkage, double reach) const {
  constexpr double least = 1e-6;  // of the mean variance
  double sum = 0;
  for (const NoiseSite& s : sites_) {
    const Sums all = near(s.u, 0, &s);
    const double mean = std::max(all.squares / all.freedom, least * mean_);
    const Sums here = reach > 0 ? near(s.u, reach, &s) : Sums{};
    const double freedom = reach > 0 ? shrinkage + here.freedom : all.freedom;
    const double variance = reach > 0 ? (shrinkage * mean + here.squares) / freedom : mean;
    sum += log_density(s, variance, freedom);
  }
  return sum;
}

double LocalNoise::factor(const VectorXd& u) const {
  if (uniform()) return 1;
  const Sums here = near(u, reach_, nullptr);
  return (shrinkage_ * mean_ + here.squares) / (shrinkage_ + here.freedom);
}

double LocalNoise::freedom(const VectorXd& u) const {
  return shrinkage_ + near(u, reach_, nullptr).freedom;
}

}  // namespace firn
