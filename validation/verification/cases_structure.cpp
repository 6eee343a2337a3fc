// Stacks and arches.
#include "validation/verification/check.h"

namespace firn::verification {

std::vector<VerificationCase> structure_cases() { return {}; }

}  // namespace firn::verification
