// Phase of a step: contacts between boundaries (model.boundary_contacts).
#pragma once

#include <cstddef>

#include "firn/body_state.h"
#include "firn/model.h"

namespace firn {

struct State;
struct Workspace;

// Call if the model has such contacts. Throws RunError when an overlap exceeds its limit.
void boundary_contacts(const Model& model, Workspace& workspace, State& state);

// Power of the load of a contact on both of its boundaries at their velocities, W.
double boundary_contact_power(const Model& model, const State& state, std::size_t number);

BoundaryContactState boundary_contact_state(const Workspace& workspace, const State& state,
                                            std::size_t number);

}  // namespace firn
