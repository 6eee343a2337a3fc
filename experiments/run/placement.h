// Random placement of the bodies of a fill.
#pragma once

#include <string>
#include <vector>

#include "experiments/case/case.h"
#include "firn/solver.h"

namespace firn {

// Sets the initial state of a case: frames with another initial pose, and particles at given
// positions.
void place_start(Solver& solver, const Case& c);

// Inserts waiting particles [first, first + count) of fill `index` of the case, all of one shape,
// by random sequential addition: the orientation first, uniform over all rotations; then the
// position, uniform over where the body lies wholly inside the region. A body that would overlap
// another one or a boundary is tried again with a new orientation.
// Throws InputError("...: impossible fill: ...") after kPlacementTries for one body.
inline constexpr int kPlacementTries = 20000;
void place_batch(Solver& solver, const Case& c, std::size_t index, std::uint64_t batch, int first,
                 int count);

}  // namespace firn
