// [statistics] of a case file: contact statistics over all steps (docs/statistics.md).
#pragma once

#include "experiments/case/case.h"
#include "experiments/text/toml_document.h"

namespace firn {

// Sets the statistics of the model, Case::statistics_stage and Case::wear_rate. The case must have
// its shapes, boundaries and stages.
void read_statistics(const TomlTable& root, Case& c);

}  // namespace firn
