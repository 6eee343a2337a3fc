// Initial positions of particles: those of the initial state, and random ones of a fill.
#pragma once

#include <string>
#include <vector>

#include "experiments/case/case.h"
#include "firn/solver.h"

namespace firn {

// Applies the initial state of a case: poses and velocities of motion frames, and the particles of
// [initial_state] and [[particles]].
void place_start(Solver& solver, const Case& c);

// Inserts the pending particles [first, first + count) of fill `index` of the case, all of one
// shape, by random sequential addition. The orientation is uniform over all rotations. The position
// is uniform over the positions at which the body is wholly inside the region. A body that would
// overlap another one or a boundary is drawn again. Throws InputError "...: impossible fill: ..."
// after kPlacementTries for one body.
inline constexpr int kPlacementTries = 20000;
void place_batch(Solver& solver, const Case& c, std::size_t index, std::uint64_t batch, int first,
                 int count);

}  // namespace firn
