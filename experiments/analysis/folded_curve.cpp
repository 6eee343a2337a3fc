#include "experiments/analysis/folded_curve.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace firn {
namespace {

constexpr double kBinTolerance = 1e-6;  // of the length of a bin

struct CurveBin {
  double sum = 0, count = 0;
  double least = std::numeric_limits<double>::infinity();
  double most = -std::numeric_limits<double>::infinity();
};

}  // namespace

FoldedCurve folded_curve(std::span<const double> x, std::span<const double> y, double period,
                         std::size_t bins) {
  std::vector<CurveBin> all(bins);
  for (std::size_t i = 0; i < std::min(x.size(), y.size()); ++i) {
    if (!std::isfinite(x[i]) || !std::isfinite(y[i])) continue;
    const double periods = x[i] / period;
    const double place = (periods - std::floor(periods)) * static_cast<double>(bins);
    CurveBin& bin = all[static_cast<std::size_t>(place + kBinTolerance) % bins];
    bin.sum += y[i];
    bin.count += 1;
    bin.least = std::min(bin.least, y[i]);
    bin.most = std::max(bin.most, y[i]);
  }
  FoldedCurve folded;
  for (std::size_t k = 0; k < bins; ++k) {
    if (all[k].count == 0) continue;
    folded.x.push_back((static_cast<double>(k) + 0.5) * period / static_cast<double>(bins));
    folded.mean.push_back(all[k].sum / all[k].count);
    folded.least.push_back(all[k].least);
    folded.most.push_back(all[k].most);
  }
  return folded;
}

}  // namespace firn
