// [statistics] of a case file: what is kept of contacts over every step. docs/statistics.md.
#pragma once

#include "experiments/toml_reader.h"
#include "solver/model.h"

namespace firn {

StatisticsOptions read_statistics(const TomlTable& root);

}  // namespace firn
