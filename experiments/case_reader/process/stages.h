// [[stages]]: successive parts of a run and the events that end them.
#pragma once

#include <string_view>
#include <vector>

#include "experiments/case/case.h"
#include "experiments/text/toml_document.h"

namespace firn {

// The case must have its boundaries, frames, sensors and limit switches.
std::vector<Stage> read_stages(const TomlTable& root, const Case& c);

// Index of the stage that the key names; -1 without the key. Throws InputError for another name.
int optional_stage(const TomlTable& t, std::string_view key, const std::vector<Stage>& stages);

// Throws InputError if a fill, an inlet or a tag rule names an unknown stage.
void check_stage_names(const TomlTable& root, const Case& c);

}  // namespace firn
