// The same scene told differently.
#include "validation/verification/check.h"

namespace firn::verification {

std::vector<VerificationCase> invariance_cases() { return {}; }

}  // namespace firn::verification
