// Phase of a step: contact forces.
#pragma once

#include "firn/model.h"

namespace firn {

struct State;
struct Workspace;

// Advances the force law of all patches and sums the loads on bodies and boundaries.
// Throws RunError when an overlap exceeds its limit.
void contact_forces(const Model& model, Workspace& workspace, State& state);

}  // namespace firn
