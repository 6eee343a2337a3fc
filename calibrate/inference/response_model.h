// Models of the responses fitted to the runs: the noise, the dependence on the parameters, and the
// misfit of a parameter set to the measurements.
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <string>
#include <vector>

#include "calibrate/numerics/noise_model.h"
#include "calibrate/numerics/optimize.h"
#include "calibrate/numerics/surrogate.h"
#include "calibrate/study/study_runs.h"
#include "experiments/analysis/sample_statistics.h"

namespace firn {

// Standard deviation of one run about the mean over seeds, pooled over all points that have
// several. Either it is constant, or it is a fraction of the response: few seeds hardly distinguish
// the two, so that both are averaged by their probabilities, which are equal before the data.
struct NoiseModel {
  double constant_sd = 0;           // unit of the response
  double relative_sd = 0;           // fraction of the response
  double relative_probability = 0;  // 0 where the response is not positive
  int degrees_of_freedom = 0;

  bool is_relative() const { return relative_probability > 0.5; }
  double at(double level) const;  // root mean square over both, unit of the response
};
// Nothing without two runs anywhere.
std::optional<NoiseModel> pool_noise(const std::vector<Sample>& samples);
// The same of two sets together, where the spreads of both agree (Fisher's distribution, at 1 %);
// else of the first alone.
std::optional<NoiseModel> pool_noise(const std::vector<Sample>& samples,
                                     const std::vector<Sample>& others);

struct ResponseModel {
  ResponseId response;
  std::string unit;
  NoiseModel noise;
  SurrogateChoice surrogate;
  std::vector<Sample> samples;     // one per point of the fit
  double lowest = 0, highest = 0;  // means of the points of high fidelity, if there are any
  double largest_leave_one_out_z = 0;
  std::vector<NoiseSite> noise_sites = {};  // relative to `noise`
  LocalNoise local_noise = {};              // of these sites
  // Whether the largest leave-one-out error has a probability above 1 %. If not, the uncertainty
  // that the model states is not reliable.
  bool passes_cross_validation() const;
  // Variance of one run between seeds at u, where the mean response is `mean`: pooled, and that of
  // the neighborhood where the noise is not uniform, each widened by its degrees of freedom.
  double run_variance(const Eigen::VectorXd& u, double mean) const;
};

// Probability of an outcome of a run of an experiment near a point: a smoothed count.
class OutcomeProbability {
 public:
  // Probability of `counted` among the runs that ended so or as one of `among`.
  OutcomeProbability(const std::vector<Point>& points, std::size_t experiment,
                     const std::vector<JobStatus>& counted, const std::vector<JobStatus>& among);
  bool any() const { return any_; }
  double at(const Eigen::VectorXd& u) const;

 private:
  std::vector<Eigen::VectorXd> u_;
  std::vector<double> counted_, runs_;
  bool any_ = false;
};

// Models of all responses, fitted to the runs so far.
struct ResponseModels {
  std::vector<ResponseModel> targets;   // in order of Study::targets
  std::vector<ResponseModel> observed;  // those of Study::observed that could be modeled
  // By experiment. A run that arches is evidence against its parameters, because the experiment did
  // not arch. A run that failed or was cut short by a limit is not: its response is unknown.
  std::vector<OutcomeProbability> arched, cut_short;

  double arch_probability(const Eigen::VectorXd& u) const;  // in any experiment
  double cut_short_probability(const Eigen::VectorXd& u) const;
};
// The model of one response. Points outside the ranges are left out. Nothing when the finished runs
// are too few. `elsewhere` are points of the other choices of the study: they inform the noise
// alone.
std::optional<ResponseModel> fit_response_model(const ResponseId& response,
                                                const std::vector<Point>& points,
                                                const std::vector<Point>& elsewhere = {});
// Those of all responses of a study. Nothing when the finished runs of a target are too few.
std::optional<ResponseModels> fit_response_models(const Study& study,
                                                  const std::vector<Point>& points,
                                                  const std::vector<Point>& elsewhere = {});

// Misfit of a parameter set to the measurements.
class NegativeLogPosterior {
 public:
  NegativeLogPosterior(const Study& study, const ResponseModels& models)
      : study_(study), models_(models) {}

  // Minus twice the logarithm of the posterior density up to a constant: for each target (m - y)^2
  // / V + ln V with V the variance of measurement, discrepancy and surrogate, plus the given
  // priors, a steep penalty beyond constraints, and -2 ln of the probability that the flow does not
  // arch.
  double cost(const Eigen::VectorXd& u) const;
  // cost() with a weak regularization towards the middle of the ranges, which selects one of
  // several equal minima. A distance of one range costs as much as one standard deviation of a
  // target.
  double regularized_cost(const Eigen::VectorXd& u) const;
  // Whitened residuals (m - y) / sqrt(V) of the targets, then the priors of single parameters, the
  // regularization, other priors and violations of constraints; V as it is at `frozen`.
  LeastSquaresProblem residuals(const Eigen::VectorXd& frozen) const;
  // (m - y) / sqrt(V) of each target.
  Eigen::VectorXd z(const Eigen::VectorXd& u) const;
  // The global minimum of regularized_cost: NLopt, then Ceres where it improves on it.
  Minimum best() const;

 private:
  Eigen::Index dimensions() const { return static_cast<Eigen::Index>(study_.parameters.size()); }

  const Study& study_;
  const ResponseModels& models_;
};

}  // namespace firn
