// Responses of the scene language: what sensors counted, limit switches and inlets did, frames
// bore.
#pragma once

#include <vector>

#include "experiments/case/case.h"
#include "experiments/results/response.h"

namespace firn {

class Recording;

// Named after the case's own names, blanks replaced by underscores. None for a case without
// sensors, limit switches, inlets and motion frames.
std::vector<Response> scene_responses(const Recording& recording, const Case& c);

}  // namespace firn
