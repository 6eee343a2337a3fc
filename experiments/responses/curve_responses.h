// Curves of one quantity over another, such as force over displacement: [[measure]] of kind
// "curve".
#pragma once

#include <vector>

#include "experiments/case/case.h"
#include "experiments/results/response.h"

namespace firn {

class Recording;

// For each of these measures: NAME_curve_x and NAME_curve_y, of equal length, in the order of time.
// One value per frame. Forces and torques are magnitudes of the means since the previous frame.
// Folded curves have one value per bin of the period, in the order of x, bins without frames left
// out: the mean over all frames but the first, and NAME_curve_y_min and NAME_curve_y_max.
std::vector<Response> curve_responses(const Recording& recording, const Case& c);

}  // namespace firn
