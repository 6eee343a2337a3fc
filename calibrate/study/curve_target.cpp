#include "calibrate/study/curve_target.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "experiments/batch/execution/executor.h"

namespace firn {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// How far the places may lie beyond the samples, as a share of their extent: a run ends between two
// frames.
constexpr double overhang = 0.02;

}  // namespace

std::optional<VectorXd> sampled_curve(const std::vector<double>& x, const std::vector<double>& y,
                                      const VectorXd& places) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < std::min(x.size(), y.size()); ++i)
    if (std::isfinite(x[i]) && std::isfinite(y[i])) order.push_back(i);
  if (order.size() < 2) return std::nullopt;
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return x[a] < x[b]; });
  const double first = places[0], last = places[places.size() - 1];
  const double slack = overhang * (last - first);
  if (x[order.front()] > first + slack || x[order.back()] < last - slack) return std::nullopt;
  VectorXd sampled(places.size());
  std::size_t at = 0;  // the segment from order[at] to order[at + 1]
  for (Index i = 0; i < places.size(); ++i) {
    while (at + 2 < order.size() && x[order[at + 1]] < places[i]) ++at;
    const std::size_t a = order[at], b = order[at + 1];
    const double part = x[b] > x[a] ? std::clamp((places[i] - x[a]) / (x[b] - x[a]), 0.0, 1.0) : 0;
    sampled[i] = y[a] + part * (y[b] - y[a]);
  }
  return sampled;
}

std::optional<VectorXd> simulated_curve(const CurveTarget& target, const JobResult& run) {
  const auto find = [&](const char* end, const std::string& unit) {
    const std::string name = target.name + end;
    if (const auto values = response_values(run, name, unit)) return *values;
    throw InputError(
        fmt::format("\"{}\" in \"{}\" is not a response of the run; expected the name of a "
                    "[[measure]] of the kind "
                    "\"curve\", in units of the same kind",
                    name, unit));
  };
  const std::vector<double> x = find("_curve_x", target.x_unit), y = find("_curve_y", target.unit);
  return sampled_curve(x, y, target.x);
}

}  // namespace firn
