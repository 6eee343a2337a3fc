// Phases of a step: motion frames and the boundaries that they carry.
#pragma once

#include "firn/model.h"

namespace firn {

struct BodyLoad;
struct State;
struct Workspace;

// Prescribed motions of frames and boundaries; first half-kick and drift of free bodies.
void advance_boundaries(const Model& model, Workspace& workspace, State& state);
// Second half-kick of free bodies, and impulses on frames.
void finish_frames(const Model& model, Workspace& workspace, State& state);

// Force and torque (about the origin of the frame) of contacts on all boundaries that the frame
// carries, at this step.
BodyLoad load_on_frame(const Model& model, const State& state, int frame);

}  // namespace firn
