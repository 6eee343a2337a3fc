// Responses from contact statistics. Methods: docs/responses.md.
#pragma once

#include <vector>

#include "experiments/case/case.h"
#include "experiments/results/response.h"
#include "experiments/results/results_file.h"

namespace firn {

// Empty for a case without statistics.
std::vector<Response> statistics_responses(const Recording& recording, const Case& c);

}  // namespace firn
