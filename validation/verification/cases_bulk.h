// The parts of the bulk group.
#pragma once

#include "validation/verification/check.h"

namespace firn::verification {

std::vector<VerificationCase> packing_cases();  // fractions
std::vector<VerificationCase> silo_cases();     // Janssen

}  // namespace firn::verification
