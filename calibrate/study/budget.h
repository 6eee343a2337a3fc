// The [budget] table of a study, and how a number of runs is divided when that is all it says.
#pragma once

#include "calibrate/study/study_file.h"
#include "experiments/text/toml_document.h"

namespace firn {

// Everything else of the study must have been read. Throws InputError.
Budget read_budget(const TomlTable& root, const Study& study);

}  // namespace firn
