// [initial_state] of a case file: start from the state of an earlier run.
#pragma once

#include <string>

#include "experiments/case/case.h"
#include "experiments/text/toml_document.h"

namespace firn {

// Sets c.placed and its particles of the model, c.frame_starts and c.start. The case must have its
// shapes and motion frames. The values from the results file are written into the table, so that
// the resolved case does not need the file. Throws InputError for a results file that does not
// match the case.
void read_initial_state(const TomlTable& root, const std::string& directory, Case& c);

}  // namespace firn
