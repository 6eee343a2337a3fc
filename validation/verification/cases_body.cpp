// One rigid body.
#include "validation/verification/check.h"

namespace firn::verification {

std::vector<VerificationCase> body_cases() { return {}; }

}  // namespace firn::verification
