// Responses of sensors, limit switches, inlets and motion frames.
#pragma once

#include <vector>

#include "experiments/case/case.h"
#include "experiments/results/response.h"

namespace firn {

class Recording;

// Response names begin with the names of the case, in which underscores replace blanks. Empty for a
// case without sensors, limit switches, inlets and motion frames.
std::vector<Response> process_responses(const Recording& recording, const Case& c);

}  // namespace firn
