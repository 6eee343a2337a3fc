// Phase of a step: work of contacts with particles and boundaries that have been removed.
#pragma once

#include "firn/model.h"

namespace firn {

struct State;
struct Workspace;

// The last load of a removed body still acts on its partners in the first half-kick of the next
// step, but its contacts end before the force law computes their work in that step. This adds the
// work that the load takes from the partners over half a step, at their velocities between the two
// half-kicks. A boundary that moves is a partner, too. What the contacts hold then counts as
// dissipated. Call it after bodies have moved and before the neighbor list is updated. Nothing is
// missing for a removed boundary: each step counts the whole impulse of its loads at its end.
void add_work_of_removed_bodies(const Model& model, const Workspace& workspace, State& state);

}  // namespace firn
