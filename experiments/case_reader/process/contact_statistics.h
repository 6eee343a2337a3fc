// [statistics] of a case file: contact statistics over all steps (docs/statistics.md).
#pragma once

#include "experiments/text/toml_document.h"
#include "firn/model.h"

namespace firn {

// The model must have its shapes and boundaries. Sets `wear_rate` (1/Pa), the wear coefficient over
// the hardness (Archard); 0 without the keys.
StatisticsOptions read_statistics(const TomlTable& root, const Model& model, double& wear_rate);

}  // namespace firn
