// [[targets]] and [[observe]] of a study file: the responses that a study reproduces or reports.
#pragma once

#include <cstddef>

#include "calibrate/study/study_file.h"

namespace firn {

class TomlTable;

// The experiment that a target, an observation or a check names. Throws InputError with file, line
// and key.
std::size_t named_experiment(const TomlTable& t, const Study& study);

// After the experiments. `head`: the table [study]. Throws InputError with file, line and key.
void read_responses(const TomlTable& root, const TomlTable& head, Study& study);

}  // namespace firn
