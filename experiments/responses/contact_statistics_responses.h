// Responses from contact statistics. Methods: docs/responses.md.
#pragma once

#include <vector>

#include "experiments/case/case.h"
#include "experiments/results/response.h"
#include "experiments/results/results_file.h"

namespace firn {

// False where the run ended before the stage with which the statistics of the case, and the largest
// forces of particles, begin.
bool statistics_began(const Recording& recording, const Case& c);

// Empty for a case without statistics, and where they did not begin.
std::vector<Response> statistics_responses(const Recording& recording, const Case& c);

}  // namespace firn
