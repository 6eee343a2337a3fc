// Two-sided loads on particles, over every step (see CompressiveLoad).
#pragma once

#include "firn/model.h"

namespace firn {

struct State;
struct Workspace;

// Part of the phase: updates the largest load of each particle.
void record_compressive_loads(const Model& model, Workspace& workspace, State& state);

}  // namespace firn
