// [[measure]] of a case file: measurements of single bodies, heaps and machine parts.
#pragma once

#include <vector>

#include "experiments/case/case.h"
#include "experiments/text/toml_document.h"

namespace firn {

// The case must have its model, its stages and its output interval.
std::vector<Measure> read_measures(const TomlTable& root, const Case& c);

}  // namespace firn
