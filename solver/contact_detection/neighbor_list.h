// Phase of a step: the list of pairs of bodies with close parts.
#pragma once

#include "firn/model.h"

namespace firn {

struct State;
struct Workspace;

// Rebuilds the list when a body has moved further than its skin.
void update_neighbor_list(const Model& model, Workspace& workspace, State& state);

}  // namespace firn
