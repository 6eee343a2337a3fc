// Verification cases of this folder, by group.
#pragma once

#include <vector>

#include "validation/verification/fixtures/check.h"

namespace firn::verification {

std::vector<VerificationCase> invariance_cases();    // "invariance.": equivalent setups
std::vector<VerificationCase> mesh_cases();          // "invariance.": other meshes, other parts
std::vector<VerificationCase> tessellation_cases();  // "invariance.": the same solid cut otherwise
std::vector<VerificationCase> curved_wall_cases();   // "invariance.": facets that are refined
std::vector<VerificationCase> robustness_cases();    // "robustness.": extreme setups

}  // namespace firn::verification
