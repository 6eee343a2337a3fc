// Contact by contact: sums of the interaction of pairs of bodies, over every step.
#pragma once

#include <vector>

#include "firn/contact_statistics.h"
#include "firn/model.h"

namespace firn {

struct State;
struct Workspace;

// Part of the phase: begins, continues and ends contacts.
void update_contact_events(const Model& model, Workspace& workspace, State& state);

// Open contacts, in order of their start and bodies.
std::vector<ContactEvent> open_events(const Model& model, const State& state);

}  // namespace firn
