// [initial_state] of a case file: the state of an earlier run as the beginning of this one.
#pragma once

#include <string>

#include "experiments/case/case.h"
#include "experiments/text/toml_document.h"

namespace firn {

// Reads c.placed, their particles of the model, c.frame_starts and c.start; shapes and motion
// frames have been read. What is taken of the results file is written into the table, so that the
// resolved case needs the file no more. Throws InputError for a file that does not fit the case.
void read_start(const TomlTable& root, const std::string& directory, Case& c);

}  // namespace firn
