// A periodic quantity over one period.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace firn {

// Statistics of y in bins of x, of equal length. Bins without a value are left out.
struct FoldedCurve {
  std::vector<double> x;  // middle of the bin, ascending, above 0 and below the period
  std::vector<double> mean, least, most;  // of y
};

// Folds y over x, equally long: the bin of each value follows from the remainder of x after
// division by `period`, which is at least 0, also of an x below 0. An x within a millionth of a bin
// before the end of its bin counts as beyond it, so that rounding does not move multiples of the
// period out of bin 0. Values that are not finite do not count. Requires period > 0 and bins > 0.
FoldedCurve folded_curve(std::span<const double> x, std::span<const double> y, double period,
                         std::size_t bins);

}  // namespace firn
