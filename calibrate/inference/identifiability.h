// Which combinations of parameters the data determine.
//
// No normal matrix is inverted: along a direction without information, its inverse would give a
// variance of zero or infinity. Directions come from the singular values of the whitened Jacobian
// against a threshold set by the noise; widths come from the posterior over the whole range
// (posterior.h).
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <string>
#include <vector>

#include "calibrate/inference/posterior.h"
#include "calibrate/inference/response_model.h"

namespace firn {

// Contributions to a variance.
struct VarianceSplit {
  double measurement = 0, seeds = 0, surrogate = 0, discrepancy = 0;
  double total() const { return measurement + seeds + surrogate + discrepancy; }
};

// A linear combination of the (scaled) parameters, and how well the data determine it.
struct Combination {
  Eigen::VectorXd direction;  // unit vector in the unit cube
  double singular_value = 0;  // standard deviations of the data over the whole range
  bool identifiable = false;
  // sum of coefficient * (parameter or its logarithm) = value +- sd; coefficients of unit length.
  Eigen::VectorXd coefficients;
  double value = 0;
  double sd = 0;  // by the data alone, linearized; infinite when unidentified
  // Root mean square distance from `value` over the whole posterior. Much larger than sd where the
  // ridge curves away from its direction at the estimate.
  double spread = 0;
  // Largest distance from `value` within the nearest 95 % of the posterior; where the ridge is
  // curved, within the whole 95 % region.
  double distance_95 = 0;
  bool is_curved() const { return spread > 1.5 * sd; }
  VarianceSplit split;  // of sd^2
  // The reported uncertainty: valid over the whole posterior, not only near the estimate.
  double uncertainty() const { return std::max({sd, spread, distance_95 / 2}); }
};
// Variances that limit a direction: all sources, or the measurements and discrepancies alone, as if
// the responses were known exactly.
enum class VarianceSources { all, measurement };
// Combinations at u (unit cube), best determined first; as many as parameters.
std::vector<Combination> combinations(const Study& study, const ResponseModels& models,
                                      const Eigen::VectorXd& u,
                                      VarianceSources sources = VarianceSources::all);

// Fills in `spread` and `distance_95` of each combination from the posterior.
void rms_over_posterior(const Posterior& posterior, const Study& study,
                        std::vector<Combination>& all);

// Expected relative reduction of the uncertainty of a target if further runs made the responses
// exactly known over the posterior (largest over the targets). 1 where they would determine a
// combination that is not determined at u now.
double expected_narrowing(const Study& study, const ResponseModels& models,
                          const Posterior& posterior, const Eigen::VectorXd& u);

// One of several equally good parameter sets.
struct RidgeMember {
  Eigen::VectorXd u;
  std::vector<double> values;  // tidy
};
// Members from one end of the posterior to the other along its longest direction.
std::vector<RidgeMember> ridge(const Study& study, const NegativeLogPosterior& misfit,
                               const Posterior& posterior);

enum class FirstPoint { estimate, estimate_if_uncertain };
// Points at which the next runs are most informative. The first is the estimate `best`: always, or
// while the prediction there is uncertain. The others are posterior samples with the most uncertain
// predictions. Each is chosen as if the previous ones had given their predicted responses, and at a
// distance from each other and from `taken` (unit cube). `seeds`: runs of each point;
// `low_fidelity`: whether they are of low fidelity.
std::vector<Eigen::VectorXd> refinement_points(const Study& study, const ResponseModels& models,
                                               const Posterior& posterior,
                                               const Eigen::VectorXd& best, FirstPoint first,
                                               std::vector<Eigen::VectorXd> taken, int count,
                                               int seeds, bool low_fidelity = false);

}  // namespace firn
