// Responses of what a case keeps of its contacts: docs/responses.md.
#pragma once

#include <vector>

#include "experiments/case.h"
#include "experiments/recording.h"
#include "experiments/response.h"

namespace firn {

// None where the case asks for no statistics.
std::vector<Response> statistics_responses(const Recording& recording, const Case& c);

}  // namespace firn
