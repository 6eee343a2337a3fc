// The order in which the responses of a run are displayed.
#pragma once

#include <cstddef>
#include <vector>

#include "experiments/case/case.h"
#include "experiments/results/response.h"

namespace firn {

// Most informative first: what the experiment and the measures of the case ask for, inlets,
// sensors, jams, bonds, motion frames and stages, then all others in the given order. At the end
// those that measured nothing: zero within the resolution of the unit, undefined, or without
// values.
std::vector<Response> in_display_order(std::vector<Response> responses, const Case& c);

// The first responses of in_display_order() that answer what the case is about: defined numbers
// other than zero. The exception is "arched", where 0 is an answer. At most `most`.
std::vector<Response> main_responses(const std::vector<Response>& responses, const Case& c,
                                     std::size_t most = 6);

}  // namespace firn
