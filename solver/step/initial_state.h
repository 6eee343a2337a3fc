// State before the first step.
#pragma once

#include "firn/body_state.h"
#include "firn/model.h"

namespace firn {

struct State;

// Sets the sizes of all arrays of the bodies and contacts, and places boundaries and frames.
void initialize(const Model& model, State& state);
// Places boundaries and frames as drawn.
void place_boundaries(const Model& model, State& state);
// Gives a frame another pose, coordinates and rates. All that it carries moves with it.
void start_frame(const Model& model, const FrameStart& start, State& state);

}  // namespace firn
