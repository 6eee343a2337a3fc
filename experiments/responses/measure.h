// Computes the responses of a run from its results file.
#pragma once

#include <vector>

#include "experiments/case/case.h"
#include "experiments/results/response.h"
#include "experiments/results/results_file.h"

namespace firn {

// All default and requested responses of the case, computed from the results file.
std::vector<Response> measure(const Recording& recording);
// The same with the case of the file, if the caller has read it already.
std::vector<Response> measure(const Recording& recording, const Case& c);

}  // namespace firn
