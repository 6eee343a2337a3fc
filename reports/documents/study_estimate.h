// Summary of the result of a study in a few lines.
#pragma once

#include <string>
#include <vector>

#include "calibrate/output/study_document.h"
#include "reports/html/page.h"

namespace firn {

// Recommended values, or that there are none and why; identifiable combinations, results of the
// compare sets, and the next measurements. Empty when the study has no estimate.
std::vector<page::Property> study_estimate(const StudyDocument& results);

// The terms of one of its combinations: "1.00 ln(ice_ice) - 0.20 ice_plastic".
std::string combination_text(const StudyDocument::Combination& combination);

}  // namespace firn
