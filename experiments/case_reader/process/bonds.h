// [[bonds]] of a case file: which bodies are joined by which bridges.
#pragma once

#include "experiments/case/case.h"
#include "experiments/text/toml_document.h"

namespace firn {

// Adds bonds and their laws to the model, which holds all particles already. Every place is known
// before the run, so that bridges that do not reach their bodies are refused here.
void read_bonds(const TomlTable& root, Case& c);

}  // namespace firn
