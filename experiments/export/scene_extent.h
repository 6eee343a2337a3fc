// How large a plane without borders is drawn.
#pragma once

#include "experiments/results/results_file.h"

namespace firn {

// m: 1.5 times the largest distance from the origin of the world that a particle reaches in every
// `every`-th frame, its bounding radius included.
double scene_reach(const Recording& recording, const Model& model, std::size_t every);

}  // namespace firn
