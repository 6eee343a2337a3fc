#include "validation/statistics/outlier_test.h"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "experiments/analysis/sample_statistics.h"

namespace firn {
namespace {

// The value farthest from the mean of the values that are not `out`, in standard deviations.
struct Farthest {
  std::size_t index = 0;
  double deviate = -1;
};
Farthest farthest(const std::vector<double>& values, const std::vector<char>& out) {
  std::vector<double> rest;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (out[i] == 0) rest.push_back(values[i]);
  const SampleStatistics f = sample_statistics(rest);
  Farthest far;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (const double d = std::abs(values[i] - f.mean) / f.deviation; out[i] == 0 && d > far.deviate)
      far = {i, d};
  return far;
}

// Indices of the outliers, the farthest first (Rosner 1983).
std::vector<std::size_t> outliers(const std::vector<double>& values, double significance) {
  const std::size_t n = values.size(), most = std::clamp<std::size_t>(n / 10, 1, 5);
  std::vector<char> out(n, 0);
  std::vector<std::size_t> order;
  std::size_t found = 0;
  for (std::size_t i = 1; i <= most; ++i) {
    const auto [index, deviate] = farthest(values, out);
    if (!std::isfinite(deviate) || deviate < 0) break;
    const auto left = static_cast<double>(n - i + 1);
    const boost::math::students_t student(left - 2);
    const double t =
        boost::math::quantile(boost::math::complement(student, significance / (2 * left)));
    order.push_back(index);
    if (deviate > t * (left - 1) / std::sqrt((left - 2 + t * t) * left)) found = order.size();
    out[index] = 1;
  }
  order.resize(found);
  return order;
}

}  // namespace

std::optional<double> value_apart(const std::vector<double>& values, double significance) {
  if (values.size() < 5) return std::nullopt;
  std::vector<std::size_t> found = outliers(values, significance);
  if (std::ranges::all_of(values, [](double v) { return v > 0; })) {
    std::vector<double> logarithms;
    logarithms.reserve(values.size());
    for (const double v : values) logarithms.push_back(std::log(v));
    const std::vector<std::size_t> as_well = outliers(logarithms, significance);
    std::erase_if(found, [&](std::size_t i) { return std::ranges::count(as_well, i) == 0; });
  }
  return found.empty() ? std::nullopt : std::optional(values[found.front()]);
}

}  // namespace firn
