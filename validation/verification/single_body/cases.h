// Verification cases of this folder, by group.
#pragma once

#include <vector>

#include "validation/verification/fixtures/check.h"

namespace firn::verification {

std::vector<VerificationCase> impact_cases();  // "impact.": one contact, normal and oblique
std::vector<VerificationCase> energy_cases();  // "energy.": elastic impacts
std::vector<VerificationCase> body_cases();    // "body.": one rigid body, free and on a plane

}  // namespace firn::verification
