// Responses of a simulated accelerometer on a free body: [[measure]] of kind "accelerometer".
#pragma once

#include <vector>

#include "experiments/case/case.h"
#include "experiments/results/response.h"

namespace firn {

class Recording;

// For each of these measures: largest magnitudes of the filtered acceleration along the joint axis,
// from the joint rates of successive samples or frames; of the filtered contact force along the
// axis; and of the acceleration times the mass of a particle. Filter: channel_filter.h.
std::vector<Response> accelerometer_responses(const Recording& recording, const Case& c);

}  // namespace firn
