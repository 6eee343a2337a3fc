// Phase of a step: statistics (firn/contact_statistics.h).
#pragma once

#include "firn/model.h"

namespace firn {

struct State;
struct Workspace;

// Call if the model has statistics.
void update_statistics(const Model& model, Workspace& workspace, State& state);

}  // namespace firn
