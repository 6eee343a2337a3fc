// [[measure]] of a case file: what is measured of single bodies and of heaps.
#pragma once

#include <vector>

#include "experiments/case.h"
#include "experiments/toml_reader.h"

namespace firn {

// The model must have its particles and boundaries.
// `frames_every` (s): of [output], which samples must suit.
std::vector<Measure> read_measures(const TomlTable& root, const Model& model, double frames_every);

}  // namespace firn
