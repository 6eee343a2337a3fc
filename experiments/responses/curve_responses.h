// One quantity over another, for comparison with a trace: force over displacement, acceleration
// over time.
#pragma once

#include <vector>

#include "experiments/case/case.h"
#include "experiments/results/response.h"

namespace firn {

class Recording;

// Of every measure of the kind `curve`: NAME_curve_x and NAME_curve_y, as long as each other, in
// the order of time. Values of frames; forces and torques are magnitudes of the means over each
// frame.
std::vector<Response> curve_responses(const Recording& recording, const Case& c);

}  // namespace firn
