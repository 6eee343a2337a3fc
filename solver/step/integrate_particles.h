// Phases of a step: kicks and drift of all present particles.
#pragma once

#include "firn/model.h"

namespace firn {

struct State;
struct Workspace;

// First half-kick and drift. `both_kicks`: also makes the deferred second half-kick of the last
// step before.
void integrate_positions(const Model& model, Workspace& workspace, State& state, bool both_kicks);
// Second half-kick.
void finish_velocities(const Model& model, const Workspace& workspace, State& state);

}  // namespace firn
