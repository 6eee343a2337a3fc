// What bears on a part of a machine: the drag on an arm while the bucket is pulled.
#pragma once

#include <vector>

#include "experiments/case/case.h"
#include "experiments/results/response.h"

namespace firn {

class Recording;

// Of every measure of the kind `load`: NAME_load_mean and NAME_load_peak (N), over time and the
// largest of one frame, both of means over output frames that lie in the measure's stage. None
// where no such frame does.
std::vector<Response> load_responses(const Recording& recording, const Case& c);

}  // namespace firn
