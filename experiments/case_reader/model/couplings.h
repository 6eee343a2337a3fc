// [[couplings]]: constraints between bodies of a mechanism in addition to their joints.
#pragma once

#include <vector>

#include "experiments/text/toml_document.h"
#include "firn/model.h"

namespace firn {

// `frames`: all motion frames of the case.
std::vector<Coupling> read_couplings(const TomlTable& root, const std::vector<MotionFrame>& frames);

}  // namespace firn
