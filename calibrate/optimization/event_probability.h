// Probability of an event over the unit cube of the parameters, from counts of runs.
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace firn {

// Runs at one place, and those with the event.
struct EventCount {
  Eigen::VectorXd u;  // unit cube
  int events = 0, runs = 0;
};

// Logistic regression, ln(p / (1 - p)) = b_0 + sum b_i (u_i - 1/2), with independent Gaussian
// priors: b_0 with a standard deviation of 3, the others of 5, so that the odds may change by a
// factor of 150 over the range of a parameter. The posterior of b is sampled by importance from a
// Student distribution about its mode (Bishop 2006, Pattern Recognition and Machine Learning,
// sections 4.3, 4.5 and 11.1.4). Deterministic.
class EventProbability {
 public:
  EventProbability(const std::vector<EventCount>& counts, int dimensions);

  struct Prediction {
    double mean = 0;     // posterior mean of p
    double at_most = 0;  // posterior probability that p does not exceed the limit
  };
  Prediction predict(const Eigen::VectorXd& u, double limit) const;

 private:
  Eigen::MatrixXd samples_;  // [coefficients, samples], of b
  Eigen::VectorXd weights_;  // add up to 1
};

}  // namespace firn
