// Summary of the result of a study in a few lines.
#pragma once

#include <vector>

#include "reports/html/json_values.h"

namespace firn {

// From the results.json of a study: recommended values, identifiable combinations, results of the
// compare sets, and the next measurements. Empty when the study has no estimate. Throws an
// exception of the JSON library for values that are missing or of another type.
std::vector<page::Fact> study_estimate(const Json& results);

// The terms of one of its combinations: "1.00 ln(ice_ice) - 0.20 ice_plastic".
std::string combination_text(const Json& combination);

}  // namespace firn
