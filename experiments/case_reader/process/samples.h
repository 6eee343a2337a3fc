// [output.samples] of a case file: what is recorded more often than frames.
#pragma once

#include "experiments/case/case.h"
#include "experiments/text/toml_document.h"

namespace firn {

// The case must have its frames, boundaries and stages.
SampledParts read_samples(const TomlTable& root, const Case& c);

}  // namespace firn
