// Local variance of the noise of a response over the parameter space.
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace firn {

// Estimate of the noise from one point of the study, relative to the pooled variance.
struct NoiseSite {
  Eigen::VectorXd u;   // unit cube
  double squares = 0;  // sum of squared deviations over the pooled variance
  double freedom = 0;  // of that sum: expected size of `squares` where the noise is the pooled one
};

// The variance of the noise over the pooled one, as a smooth function of the parameters: a local
// mean of the sites, shrunk towards the mean of all. The shrinkage and the reach of a site follow
// from the prediction of each site by the others. Unless that is clearly better than one variance
// for all, the noise is uniform.
class LocalNoise {
 public:
  LocalNoise() = default;
  explicit LocalNoise(std::vector<NoiseSite> sites);

  bool uniform() const { return reach_ == 0; }
  double factor(const Eigen::VectorXd& u) const;   // 1 where uniform
  double freedom(const Eigen::VectorXd& u) const;  // on which the factor rests; not where uniform

 private:
  struct Sums {
    double squares = 0, freedom = 0;
  };
  Sums near(const Eigen::VectorXd& u, double reach, const NoiseSite* without) const;
  double score(double shrinkage, double reach) const;

  std::vector<NoiseSite> sites_;
  double mean_ = 1;
  double shrinkage_ = 0, reach_ = 0;  // degrees of freedom of the mean of all; unit cube
};

}  // namespace firn
