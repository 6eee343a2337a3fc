// What the parameters may still be: the posterior density over the whole range, and how far each
// parameter can move before the data object.
#pragma once

#include <Eigen/Dense>
#include <functional>
#include <vector>

#include "calibrate/inference/response_model.h"

namespace firn {

// Everything a parameter may still be, weighed by the data over the whole range.
struct Marginal {
  double mean = 0, sd = 0;  // unit cube
  // Of 95 %, the parameter's own unit: central, or one-sided from an end of the range where the
  // truth may be.
  double low = 0, median = 0, high = 0;
  double low_68 = 0, high_68 = 0;       // of the central 68 %, the parameter's own unit
  double posterior_to_prior_sd = 0;     // sd after over sd before: near 1, nothing was learned
  bool at_min = false, at_max = false;  // that end of the range is within the interval
};

struct Posterior {
  std::vector<Eigen::VectorXd> u;
  std::vector<double> weight;  // sums to 1
  std::vector<double> cost;    // minus twice the logarithm of the density, up to a constant
  double effective_samples = 0;
  // The densest region that holds 95 % of the posterior: all u whose cost is not above this.
  double hpd_95_cost = 0;
  std::vector<Marginal> marginals;
  Eigen::VectorXd longest;  // unit vector: where it stretches farthest
  // Logarithm of the mean of exp(-cost / 2) over the places of the cube that have a density: what
  // the data say for the model as a whole (the evidence), up to a constant.
  double log_evidence = 0;

  // Share of the posterior that is denser than a place of this cost: at most 0.95 inside the 95 %
  // region, uniform between 0 and 1 for the truth of many well-calibrated studies.
  double hpd_level(double place_cost) const;
};

// x such that a fraction q of the weight lies at or below it.
double weighted_quantile(const std::vector<double>& x, const std::vector<double>& weight, double q);

// Samples exp(-cost / 2) over the unit cube by sequential Monte Carlo: a quasi-random cloud over
// the cube is carried to the posterior through tempered densities, each step as long as half of the
// cloud still carries weight, and moved by Metropolis steps of the cloud's own covariance in
// between (Del Moral, Doucet and Jasra 2006; step length of Roberts, Gelman and Gilks 1997).
// Where the cost is infinite there is no density. Deterministic. `weight`, `cost`,
// `effective_samples`, `hpd_95_cost` and `log_evidence` are filled in.
Posterior sample_density(const std::function<double(const Eigen::VectorXd&)>& cost, int dimensions);

// The posterior of a study, all of it filled in.
Posterior sample_posterior(const Study& study, const NegativeLogPosterior& misfit);

// `count` of its samples, as dense as it is, for use with equal weights (systematic resampling).
std::vector<Eigen::VectorXd> resampled(const Posterior& posterior, std::size_t count);

// The cost along one parameter when all others do their best to make up for it.
struct Profile {
  std::vector<double> u;     // unit cube, equally spaced over the range
  std::vector<double> cost;  // above the least of all
  // Where the cost stays within 3.84 of the least (95 % by Wilks's theorem), own unit; an end of
  // the range where it never leaves.
  double low = 0, high = 0;
};
std::vector<Profile> profile_likelihoods(const Study& study, const NegativeLogPosterior& misfit,
                                         const Posterior& posterior);

}  // namespace firn
