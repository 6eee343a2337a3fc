// Energy accounts, and the checks that stop a run which went wrong.
#pragma once

#include "firn/diagnostics.h"
#include "firn/model.h"

namespace firn {

struct State;
struct Workspace;

// Whether the state is checked after this step.
bool is_check_step(const State& state);
// Throws RunError for non-finite motion or an unexplained rise of the energy.
void check_state(const Model& model, const Workspace& workspace, State& state);

// Energy of the particles in the present state, J. `free_bodies` of the result stays zero.
Energy energy_of(const Model& model, const Workspace& workspace, const State& state);
// Kinetic plus gravitational energy of one particle, J.
double particle_energy(const Model& model, const Workspace& workspace, const State& state,
                       int particle);

}  // namespace firn
