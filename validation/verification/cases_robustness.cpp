// The hard places.
#include "validation/verification/check.h"

namespace firn::verification {

std::vector<VerificationCase> robustness_cases() { return {}; }

}  // namespace firn::verification
