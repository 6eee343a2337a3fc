// [[priors]] of a study file.
#pragma once

#include "calibrate/study/study_file.h"

namespace firn {

class TomlTable;

// After the parameters. Throws InputError with file, line and key.
void read_priors(const TomlTable& root, Study& study);

}  // namespace firn
