// The files that the group "robustness." is made of.
#pragma once

#include <vector>

#include "validation/verification/fixtures/check.h"

namespace firn::verification {

std::vector<VerificationCase> tunneling_cases();  // fast bodies, thin walls
std::vector<VerificationCase> deep_cases();       // crushing, wedging, rest
std::vector<VerificationCase>
degenerate_shape_cases();  // flat, thin, small, badly cut, finely meshed

}  // namespace firn::verification
