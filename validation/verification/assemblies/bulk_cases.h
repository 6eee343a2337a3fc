// The parts of the bulk group.
#pragma once

#include "validation/verification/fixtures/check.h"

namespace firn::verification {

std::vector<VerificationCase> packing_cases();  // fractions
std::vector<VerificationCase> silo_cases();     // Janssen
std::vector<VerificationCase> discharge_cases();
std::vector<VerificationCase> repose_cases();  // heaps

}  // namespace firn::verification
