// Overlap of a shape in a trial pose with the bodies of a simulation, for the insertion of
// particles.
#pragma once

#include <optional>

#include "solver/state/state.h"

namespace firn {

// The first present body within `clearance` (m; below 0: an overlap that is tolerated) of a shape:
// a particle, or number of particles + boundary. Empty: none. Center of mass in m, world;
// orientation: shape axes -> world.
std::optional<int> find_obstacle(const Model& model, const State& state, int shape,
                                 const Vec3& center_of_mass, const Quat& orientation,
                                 double clearance);

}  // namespace firn
