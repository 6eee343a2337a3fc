// Contacts of a state, for inspection.
#pragma once

#include <vector>

#include "firn/solver.h"
#include "solver/state/workspace.h"

namespace firn {

// All patches of the neighbor list, in order of (a, b) and of their number (see Contact).
std::vector<Contact> contacts_of(const Workspace& workspace, const State& state);
// m, overlap of the deepest point of every patch with a force.
std::vector<double> overlaps_of(const State& state);

}  // namespace firn
