// What the data determine and what they do not.
//
// Nothing here inverts a normal matrix: along a direction that the data do not see, that would
// report a variance of nothing or of infinity. Directions come from the singular values of the
// whitened Jacobian against a threshold set by the noise; widths come from the posterior over the
// whole range (posterior.h).
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <string>
#include <vector>

#include "calibrate/inference/posterior.h"
#include "calibrate/inference/response_model.h"

namespace firn {

// Where a variance comes from.
struct VarianceSplit {
  double measurement = 0, seeds = 0, surrogate = 0, discrepancy = 0;
  double total() const { return measurement + seeds + surrogate + discrepancy; }
};

// A linear combination of the (scaled) parameters that the data pin down, or do not.
struct Combination {
  Eigen::VectorXd direction;  // unit vector in the unit cube
  double singular_value = 0;  // standard deviations of the data over the whole range
  bool identifiable = false;
  // sum of coefficient * (parameter or its logarithm) = value +- sd; coefficients of unit length.
  Eigen::VectorXd coefficients;
  double value = 0;
  double sd = 0;  // by the data alone, linearised; infinite when unidentified
  // Root mean square distance from `value` all over the posterior: much above sd where the valley
  // bends away from its direction at the answer.
  double spread = 0;
  // From `value`, of the nearest 95 % of the posterior; where the valley bends, of all of the 95 %
  // region.
  double distance_95 = 0;
  bool bends() const { return spread > 1.5 * sd; }
  VarianceSplit split;  // of sd^2
  // What is stated of it: true all over the posterior, not only near the answer.
  double uncertainty() const { return std::max({sd, spread, distance_95 / 2}); }
};
// What counts against a direction: all that is uncertain, or the measurements and the discrepancies
// alone, as if the responses were known perfectly.
enum class Against { everything, measurement };
// At u, strongest first; as many as there are parameters.
std::vector<Combination> combinations(const Study& study, const ResponseModels& knowledge,
                                      const Eigen::VectorXd& u,
                                      Against against = Against::everything);

// Fills in how far each combination strays over the posterior.
void rms_over_posterior(const Posterior& posterior, const Study& study,
                        std::vector<Combination>& all);

// How much narrower the band of a target would become, as a share of its width today, if further
// runs made the responses known perfectly all over the posterior (the largest over the targets); 1
// where they would determine a combination that is not determined at u now.
double expected_narrowing(const Study& study, const ResponseModels& knowledge,
                          const Posterior& posterior, const Eigen::VectorXd& u);

// One of several equally good answers.
struct RidgeMember {
  Eigen::VectorXd u;
  std::vector<double> values;  // tidy
};
// Members from one end of the posterior to the other along its longest direction.
std::vector<RidgeMember> ridge(const Study& study, const NegativeLogPosterior& misfit,
                               const Posterior& posterior);

enum class FirstPoint { answer, answer_if_unsure };
// Points at which the next runs are most informative: at the answer `best`, always or as long as
// the model is unsure there, and where they split the set of equally good answers best: members of
// the posterior whose predictions are least certain, each chosen as if the one before had come out
// as predicted, and away from each other and from `taken` (unit cube). Each is to be run with so
// many seeds.
std::vector<Eigen::VectorXd> refinement_points(const Study& study, const ResponseModels& knowledge,
                                               const Posterior& posterior,
                                               const Eigen::VectorXd& best, FirstPoint first,
                                               std::vector<Eigen::VectorXd> taken, int count,
                                               int seeds);

}  // namespace firn
