// Verification cases of this folder, by group.
#pragma once

#include <vector>

#include "validation/verification/fixtures/check.h"

namespace firn::verification {

std::vector<VerificationCase> structure_cases();  // "structure.": stacks, arches
std::vector<VerificationCase> bulk_cases();       // "bulk.": packings, silos, heaps
std::vector<VerificationCase> machine_cases();    // "machine.": parts in contact, joints, motors

}  // namespace firn::verification
