// The heap in a bin that is poured into from above: [[measure]] of kind "heap". Methods:
// docs/responses.md.
#pragma once

#include <vector>

#include "experiments/case/case.h"
#include "experiments/results/response.h"
#include "experiments/results/results_file.h"

namespace firn {

// From the last frame. Throws InputError when the margins leave less than two particle sizes of a
// side.
std::vector<Response> bin_heap_responses(const Recording& recording, const Case& c);

}  // namespace firn
