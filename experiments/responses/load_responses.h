// Loads on machine parts, e.g. the drag on an arm: [[measure]] of kind "load".
#pragma once

#include <vector>

#include "experiments/case/case.h"
#include "experiments/results/response.h"

namespace firn {

class Recording;

// For each of these measures: NAME_load_mean and NAME_load_peak (N), the mean and the maximum over
// the frames in the stage of the measure. The load of a frame is the mean since the previous frame.
// No responses without a frame in the stage.
std::vector<Response> load_responses(const Recording& recording, const Case& c);

}  // namespace firn
