// A test for single values that do not belong to the others. A pure function.
#pragma once

#include <optional>
#include <vector>

namespace firn {

// An outlier: found by the generalized extreme studentized deviate test (Rosner 1983) in the values
// and, where all are above zero, in their logarithms as well. Nothing below five values.
std::optional<double> value_apart(const std::vector<double>& values, double significance = 0.05);

}  // namespace firn
