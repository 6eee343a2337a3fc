// The case of a results file.
#pragma once

#include "experiments/case/case.h"
#include "experiments/results/results_file.h"

namespace firn {

// Reads the case from the resolved text in the results file. Throws InputError if the file does not
// match it.
Case read_case(const Recording& recording);

}  // namespace firn
