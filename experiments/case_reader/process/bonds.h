// [[bonds]] of a case file: breakable bonds between particles, and between particles and
// boundaries.
#pragma once

#include "experiments/case/case.h"
#include "experiments/text/toml_document.h"

namespace firn {

// Adds bonds and their laws to the model of a case that has all particles and stages. Throws
// InputError also for a bond that does not reach its bodies: all initial poses are known before the
// run.
void read_bonds(const TomlTable& root, Case& c);

}  // namespace firn
