// Effect of a reduced stiffness on responses: the exponent over simulated stiffnesses, and the
// extrapolation to the real one.
#pragma once

#include <string>
#include <vector>

#include "validation/comparison/comparison.h"

namespace firn {

// An operand's mean over seeds at the base stiffness and at each other, a straight line through
// their logarithms (weights by standard errors), and its value at `real_modulus` (Pa).
StiffnessScalingResult fit_stiffness_scaling(const std::string& operand,
                                             const ComparisonRuns& evidence, double real_modulus);

std::string stiffness_scaling_headline(const std::vector<StiffnessScalingResult>& all,
                                       double real_modulus);

}  // namespace firn
