// Particles that boundaries bear at one instant.
#pragma once

#include <vector>

#include "firn/solver.h"

namespace firn {

// Particles that touch a boundary, by the sum of its normal forces on each of them, without
// adhesion. A sum that is horizontal within a millionth counts as neither up nor down.
struct BoundarySupport {
  int above_count = 0;     // particles that the boundary pushes up, against gravity
  int below_count = 0;     // particles that it pushes down
  double above_force = 0;  // N, on the particles pushed up: sum of the upward components
};

// [boundaries of the model], as `selected`. Zero for boundaries that are not selected, and without
// gravity. At the instant of its removal, a boundary has its last contacts; a particle has none.
std::vector<BoundarySupport> boundary_support(const Solver& solver,
                                              const std::vector<bool>& selected);

}  // namespace firn
