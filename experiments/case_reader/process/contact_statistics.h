// [statistics] of a case file: what is kept of contacts over every step. docs/statistics.md.
#pragma once

#include "experiments/text/toml_document.h"
#include "firn/model.h"

namespace firn {

// The model must have its shapes and boundaries. `wear_rate` (1/Pa) is the wear coefficient over
// the hardness; 0 where the case gives none.
StatisticsOptions read_statistics(const TomlTable& root, const Model& model, double& wear_rate);

}  // namespace firn
