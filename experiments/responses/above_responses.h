// Particles that lie on boundaries, e.g. ice on a sensing arm: [[measure]] of kind "above".
#pragma once

#include <vector>

#include "experiments/case/case.h"
#include "experiments/results/response.h"

namespace firn {

class Recording;

// For each of these measures, in the last frame of its stage or of the run: NAME_above_count and
// NAME_below_count, the particles that the normal forces of the boundary push up and down, and
// NAME_above_force (N), the component of these forces against gravity, sum over the particles that
// are pushed up. No responses without a frame in the stage.
std::vector<Response> above_responses(const Recording& recording, const Case& c);

}  // namespace firn
