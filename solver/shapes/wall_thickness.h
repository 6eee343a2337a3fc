// Thickness of the walls of a solid.
#pragma once

#include "firn/mesh.h"

namespace firn {

// Thickness (m) that 95 % of the surface exceed: distance from a facet inwards to the opposite
// surface, weighted by the area of the facet. At most about 300 facets are sampled. The smallest
// edge of the bounding box where no sample has an opposite surface. The mesh must be watertight.
double wall_thickness(const TriangleMesh& mesh);

}  // namespace firn
