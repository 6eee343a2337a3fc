// Phase of a step: contact search of the listed pairs.
#pragma once

#include "firn/model.h"

namespace firn {

struct State;
struct Workspace;

// Searches the contacts of the pairs whose motion bounds allow a change, and updates their patches.
// Throws RunError when bodies have passed through each other or were placed into each other.
void find_contacts(const Model& model, Workspace& workspace, State& state);

}  // namespace firn
