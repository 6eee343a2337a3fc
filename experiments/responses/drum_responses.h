// A bed in a drum that turns: [[measure]] of kind "drum". Methods: docs/responses.md.
#pragma once

#include <vector>

#include "experiments/case/case.h"
#include "experiments/results/response.h"
#include "experiments/results/results_file.h"

namespace firn {

// From the frames from `begin` on. Throws InputError when there are fewer than ten of them.
std::vector<Response> drum_responses(const Recording& recording, const Case& c);

}  // namespace firn
