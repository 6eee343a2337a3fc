// Packings, silos, heaps.
#include "validation/verification/check.h"

namespace firn::verification {

std::vector<VerificationCase> bulk_cases() { return {}; }

}  // namespace firn::verification
