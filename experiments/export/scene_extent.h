// Size of unbounded planes in drawings.
#pragma once

#include "experiments/results/results_file.h"

namespace firn {

// Half-width of a drawn plane, m: 1.5 times the largest distance of a particle surface (bounding
// radius) from the origin of the world over every `every`-th frame.
double drawn_plane_extent(const Recording& recording, const Model& model, std::size_t every);

}  // namespace firn
