// Linear inequalities between parameters: [[constraints]] of a study.
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "calibrate/study/parameters.h"

namespace firn {

// sum of coefficient * value <= bound, in the units of the ranges.
struct Constraint {
  std::string rule;  // as written in the study
  std::vector<double> coefficients;
  double bound = 0;
};

// "dynamic <= 0.9 static": sums of numbers and of names with optional factors, on both sides of <=
// or >=. Throws InputError (one sentence).
Constraint parse_constraint(const std::string& rule, const std::vector<Parameter>& parameters);

// All constraints of a study, and a point that satisfies them.
struct Constraints {
  std::vector<Constraint> all;
  Eigen::VectorXd middle;  // unit cube; among the allowed points, the one nearest to their mean
  double share = 1;        // of the ranges that is allowed
};
// Fills in `middle` and `share`; a share of 0 leaves the middle empty.
Constraints make_constraints(std::vector<Constraint> all, const std::vector<Parameter>& parameters);

bool allowed(const Constraints& constraints, const std::vector<Parameter>& parameters,
             const Eigen::VectorXd& u);

// Violation of each constraint at u: distance in the unit cube over a tolerance of 0.001; 0 where
// it is satisfied. Derivatives [constraint, parameter], unless null.
Eigen::VectorXd violations(const Constraints& constraints, const std::vector<Parameter>& parameters,
                           const Eigen::VectorXd& u, Eigen::MatrixXd* jacobian = nullptr);

// rounded_values() of u, or where these violate a constraint, of the nearest point towards the
// middle whose values do not.
std::vector<double> allowed_values(const Constraints& constraints,
                                   const std::vector<Parameter>& parameters,
                                   const Eigen::VectorXd& u);

// `count` allowed points away from each other and from `taken`, chosen one by one.
std::vector<Eigen::VectorXd> spread_points(const Constraints& constraints,
                                           const std::vector<Parameter>& parameters, int count,
                                           std::vector<Eigen::VectorXd> taken);

}  // namespace firn
