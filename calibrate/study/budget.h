// The [budget] table of a study, and the division of a total number of runs when nothing else is
// stated.
#pragma once

#include "calibrate/study/study_file.h"
#include "experiments/text/toml_document.h"

namespace firn {

// `value`, a number of runs, points or rounds under `key`. Throws InputError for more than a batch
// may have.
int checked_count(const TomlTable& table, const char* key, int value);

// Everything else of the study must have been read. Throws InputError.
Budget read_budget(const TomlTable& root, const Study& study);

}  // namespace firn
