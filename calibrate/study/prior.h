// Prior distributions: [[priors]] of a study, in addition to prior_mean and prior_sd of a
// parameter. As residuals whose squares sum to minus twice the logarithm of the density over the
// unit cube, up to a constant.
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "calibrate/study/parameters.h"

namespace firn {

struct Prior {
  enum class Kind { normal, log_normal, beta, joint };
  Kind kind = Kind::normal;
  std::vector<std::size_t> parameters;  // indices; one, but for joint ones
  // normal: mean and standard deviation; log-normal: mean and standard deviation of the logarithm;
  // beta: the two exponents, over the range along its scale.
  double a = 0, b = 0;
  // joint: a Gaussian in the unit cube.
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
  std::string text;  // text: "normal 0.1 +- 0.02", "the study heap"

  Eigen::Index residuals() const { return static_cast<Eigen::Index>(parameters.size()); }
};

// The residuals of one prior at u and their derivatives [residual, parameter of the study].
void prior_residuals(const Prior& prior, const std::vector<Parameter>& parameters,
                     const Eigen::VectorXd& u, Eigen::VectorXd& r, Eigen::MatrixXd& jacobian);

// Minus twice the logarithm of the joint prior density, up to a constant.
double prior_cost(const std::vector<Prior>& priors, const std::vector<Parameter>& parameters,
                  const Eigen::VectorXd& u);
// Number of prior residuals; 0: no priors but the ranges.
int prior_count(const std::vector<Prior>& priors, const std::vector<Parameter>& parameters);

// Marginal prior standard deviation of one parameter in the unit cube.
double prior_sd(const std::vector<Prior>& priors, const std::vector<Parameter>& parameters,
                std::size_t index);

}  // namespace firn
