// The [experiment] block of kind "drained_repose": a box with a trap door in the middle of its
// floor. The world's origin is the middle of the floor's top; x runs along the box, z upwards.
#pragma once

#include "experiments/case/case.h"
#include "experiments/text/toml_document.h"

namespace firn {

// Adds walls, floor, door, fill, outlet and the stages "fill" and "drain" to a case whose
// materials and shapes stand already.
void read_drained_repose(const TomlTable& experiment, Case& c);

}  // namespace firn
