// Responses of a bed in a rotating drum: [[measure]] of kind "drum". Methods: docs/responses.md.
#pragma once

#include <vector>

#include "experiments/case/case.h"
#include "experiments/results/response.h"
#include "experiments/results/results_file.h"

namespace firn {

// Computed from the frames at or after Measure::begin. Undefined for fewer than ten frames.
std::vector<Response> drum_responses(const Recording& recording, const Case& c);

}  // namespace firn
