// The posterior density of the parameters over the whole range, and the profile likelihood of each
// parameter.
#pragma once

#include <Eigen/Dense>
#include <functional>
#include <vector>

#include "calibrate/inference/response_model.h"

namespace firn {

// Marginal posterior of one parameter over its whole range.
struct Marginal {
  double mean = 0, sd = 0;  // unit cube
  // Of 95 %, the parameter's own unit: central, or one-sided from an end of the range that the data
  // do not exclude; as far as the posterior where another parameter is at such an end.
  double low = 0, median = 0, high = 0;
  double low_68 = 0, high_68 = 0;       // of the central 68 %, the parameter's own unit
  double posterior_to_prior_sd = 0;     // near 1: the data add no information
  bool at_min = false, at_max = false;  // that end of the range is within the interval
};

struct Posterior {
  std::vector<Eigen::VectorXd> u;
  std::vector<double> weight;  // sums to 1
  std::vector<double> cost;    // minus twice the logarithm of the density, up to a constant
  double effective_samples = 0;
  // Bound of the densest region that holds 95 % of the posterior: all u with a cost up to this
  // value.
  double hpd_95_cost = 0;
  std::vector<Marginal> marginals;
  Eigen::VectorXd longest;  // unit vector: direction of the largest extent of the posterior
  // Evidence: logarithm of the mean of exp(-cost / 2) over the points of the cube with a finite
  // cost, up to a constant.
  double log_evidence = 0;

  // Share of the posterior that is denser than a point of this cost: at most 0.95 inside the 95 %
  // region. For the true parameters of many well-calibrated studies it is uniform between 0 and 1.
  double hpd_level(double place_cost) const;
};

// Samples exp(-cost / 2) over the unit cube by sequential Monte Carlo: quasi-random samples of the
// cube are moved to the posterior through tempered densities. Each tempering step keeps half of the
// effective samples. Metropolis steps with the covariance of the samples follow each tempering step
// (Del Moral, Doucet and Jasra 2006; step length of Roberts, Gelman and Gilks 1997). Where the cost
// is infinite there is no density. Deterministic. `weight`, `cost`, `effective_samples`,
// `hpd_95_cost` and `log_evidence` are filled in.
Posterior sample_density(const std::function<double(const Eigen::VectorXd&)>& cost, int dimensions);

// The posterior of a study with all members filled in.
Posterior sample_posterior(const Study& study, const NegativeLogPosterior& misfit);

// `count` samples of equal weight (systematic resampling).
std::vector<Eigen::VectorXd> resampled(const Posterior& posterior, std::size_t count);

// Profile likelihood: the minimum cost over all other parameters along one parameter.
struct Profile {
  std::vector<double> u;     // unit cube, equally spaced over the range
  std::vector<double> cost;  // minus its minimum
  // Interval in which the cost stays within 3.84 of its minimum (95 % by Wilks's theorem), in the
  // unit of the parameter; a bound of the range where the cost does not exceed it.
  double low = 0, high = 0;
};
std::vector<Profile> profile_likelihoods(const Study& study, const NegativeLogPosterior& misfit,
                                         const Posterior& posterior);

}  // namespace firn
