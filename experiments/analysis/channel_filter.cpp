#include "experiments/analysis/channel_filter.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace firn {
namespace {

// One pass, from rest at the first value.
void filter_forwards(std::vector<double>& x, double w) {
  const double scale = 1 + std::numbers::sqrt2 * w + w * w;
  const double a0 = w * w / scale, b1 = -2 * (w * w - 1) / scale,
               b2 = (-1 + std::numbers::sqrt2 * w - w * w) / scale;
  double x1 = x[0], x2 = x[0], y1 = x[0], y2 = x[0];
  for (double& value : x) {
    const double y = a0 * (value + 2 * x1 + x2) + b1 * y1 + b2 * y2;
    x2 = x1;
    x1 = value;
    y2 = y1;
    y1 = y;
    value = y;
  }
}

}  // namespace

std::vector<double> channel_filter(const std::vector<double>& samples, double interval,
                                   double cfc) {
  std::vector<double> x = samples;
  if (x.empty()) return x;
  const double w = std::tan(std::numbers::pi * cfc * 2.0775 * interval);
  for (int pass = 0; pass < 2; ++pass) {
    filter_forwards(x, w);
    std::ranges::reverse(x);
  }
  return x;
}

}  // namespace firn
