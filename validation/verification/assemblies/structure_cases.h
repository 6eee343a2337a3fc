// The parts of the structure group.
#pragma once

#include <string>
#include <vector>

#include "validation/verification/fixtures/check.h"

namespace firn::verification {

std::vector<VerificationCase> arch_cases();

// How far (m) something came down, when it must stand or fall.
Check stands(std::string what, double fall, double limit);
Check falls(std::string what, double fall, double limit);

}  // namespace firn::verification
