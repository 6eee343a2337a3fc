// Responses of a heap in a bin filled from above: [[measure]] of kind "heap". Methods:
// docs/responses.md.
#pragma once

#include <vector>

#include "experiments/case/case.h"
#include "experiments/results/response.h"
#include "experiments/results/results_file.h"

namespace firn {

// Computed from the last frame. Throws InputError if the margins leave less than two particle sizes
// on a side of the peak.
std::vector<Response> bin_heap_responses(const Recording& recording, const Case& c);

}  // namespace firn
