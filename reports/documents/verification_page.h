// The verification suite as a page.
#pragma once

#include <string>
#include <vector>

#include "validation/verification/suite.h"

namespace firn {

// Writes FILE.html (one page that stands alone, also on paper) or FILE.md: for every case what is
// simulated, what it is compared with, each number with its tolerance, and whether it holds. Cases
// that have not run are marked. Replaces an older page in one go. `program` names the version that
// ran. Throws InputError for another extension or a folder that cannot be written.
void write_verification_page(const std::vector<verification::VerificationCase>& cases,
                             const std::vector<verification::CaseResult>& results,
                             const std::string& program, const std::string& file);

// The measured value of a check with its unit. What is negligible compared with what the check is
// held against is 0.
std::string measured_value_text(const verification::Check& check);

// "63 %", of the fraction of a tolerance that is used.
std::string used_text(double fraction);

// "1 %", "0.002 m", "at most": how exactly a check must be met.
std::string tolerance_text(const verification::Check& check);

}  // namespace firn
