// What an accelerometer on a part that gives way would read.
#pragma once

#include <vector>

#include "experiments/case/case.h"
#include "experiments/results/response.h"

namespace firn {

class Recording;

// Of every measure of the kind `accelerometer`: largest magnitudes of the filtered acceleration,
// from the rates of neighbouring frames, of the filtered contact force along the axis, and of
// acceleration times the mass of a particle.
std::vector<Response> accelerometer_responses(const Recording& recording, const Case& c);

}  // namespace firn
