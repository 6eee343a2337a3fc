// Table [experiment] of kind "drained_repose": a box with a trap door in the middle of its floor.
// The origin of the world is the middle of the upper side of the floor; x along the box, z upwards.
#pragma once

#include "experiments/case/case.h"
#include "experiments/text/toml_document.h"

namespace firn {

// Adds walls, floor, door, fill, outlet and the stages "fill" and "drain" to a case. The case must
// have its materials and shapes.
void read_drained_repose(const TomlTable& experiment, Case& c);

}  // namespace firn
