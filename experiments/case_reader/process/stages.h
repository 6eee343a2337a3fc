// [[stages]]: what a run does one after the other, and on what events each part ends.
#pragma once

#include <vector>

#include "experiments/case/case.h"
#include "experiments/text/toml_document.h"

namespace firn {

// Boundaries, frames, sensors and limit switches of the case have been read.
std::vector<Stage> read_stages(const TomlTable& root, const Case& c);

// Fills, inlets and tag rules name stages that there are. Throws InputError.
void check_stage_names(const TomlTable& root, const Case& c);

}  // namespace firn
