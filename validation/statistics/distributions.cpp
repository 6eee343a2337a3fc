#include "validation/statistics/distributions.h"

#include <fmt/core.h>

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <cassert>
#include <cmath>
#include <numeric>

#include "experiments/analysis/sample_statistics.h"
#include "firn/math.h"

namespace firn {
namespace {

// The value of the empirical distribution of a sorted sample.
double share_up_to(const std::vector<double>& sorted, double x) {
  return static_cast<double>(std::ranges::upper_bound(sorted, x) - sorted.begin()) /
         static_cast<double>(sorted.size());
}

std::vector<double> sorted(std::vector<double> values) {
  std::ranges::sort(values);
  return values;
}

std::vector<double> joined(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> all = a;
  all.insert(all.end(), b.begin(), b.end());
  return sorted(std::move(all));
}

}  // namespace

Interval DistributionBand::at(double value) const {
  const auto next = std::ranges::upper_bound(x, value);
  if (next == x.begin()) return {0, 0};
  const auto i = static_cast<std::size_t>(next - x.begin()) - 1;
  return {lower[i], upper[i]};
}

DistributionBand empirical_distribution(std::vector<double> values) {
  values = sorted(std::move(values));
  DistributionBand band;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i + 1 < values.size() && values[i + 1] == values[i]) continue;
    band.x.push_back(values[i]);
    band.lower.push_back(static_cast<double>(i + 1) / static_cast<double>(values.size()));
  }
  band.upper = band.lower;
  return band;
}

DistributionBand distribution_from_summary(int n, double minimum, double maximum, double mean) {
  const int inner = n - 2;  // values of which only the sum is known
  const double sum = n * mean - minimum - maximum, slack = 1e-9 * n * (std::abs(maximum) + 1e-300);
  if (n < 2 || minimum > maximum || sum < inner * minimum - slack || sum > inner * maximum + slack)
    throw InputError(
        fmt::format("no {} values lie between {:.6g} and {:.6g} and have the mean {:.6g}; expected "
                    "smallest <= mean <= largest value that go together",
                    n, minimum, maximum, mean));
  // k of the inner values can lie at or below x as long as the others can make up for it, and k
  // above it in the same way.
  DistributionBand band;
  band.x = {minimum, maximum};
  for (int k = 1; k <= inner; ++k) {
    band.x.push_back((sum - (inner - k) * maximum) / k);
    band.x.push_back((sum - (inner - k) * minimum) / k);
  }
  std::erase_if(band.x, [&](double x) { return x < minimum || x > maximum; });
  std::ranges::sort(band.x);
  band.x.erase(std::unique(band.x.begin(), band.x.end()), band.x.end());
  for (const double x : band.x) {
    int below = 0, above = 0;  // as many as can be
    for (int k = 1; k <= inner; ++k) {
      if (sum <= k * x + (inner - k) * maximum + slack) below = k;
      if (sum > k * x + (inner - k) * minimum + slack) above = k;
    }
    const bool end = x >= maximum;
    band.upper.push_back(end ? 1 : (1.0 + below) / n);
    band.lower.push_back(end ? 1 : (1.0 + inner - above) / n);
  }
  return band;
}

std::optional<DistributionBand> distribution_of(const Measurement& m) {
  if (m.scatter == ScatterKind::values) return empirical_distribution(m.values);
  if (m.scatter == ScatterKind::range)
    return distribution_from_summary(m.repeats, m.minimum, m.maximum, m.value);
  return std::nullopt;
}

double distribution_band_width(int n, double confidence) {
  return std::sqrt(std::log(2 / (1 - confidence)) / (2.0 * n));
}

Interval area_metric(const std::vector<double>& sample, const DistributionBand& other) {
  const std::vector<double> mine = sorted(sample), at = joined(mine, other.x);
  Interval area;
  for (std::size_t i = 0; i + 1 < at.size(); ++i) {
    const double width = at[i + 1] - at[i], f = share_up_to(mine, at[i]);
    const Interval g = other.at(at[i]);
    area.low += width * std::max({0.0, g.low - f, f - g.high});
    area.high += width * std::max(std::abs(f - g.low), std::abs(f - g.high));
  }
  return area;
}

double total_variation_distance(const std::vector<double>& a, const std::vector<double>& b) {
  assert(a.size() == b.size());
  const double all_a = std::accumulate(a.begin(), a.end(), 0.0),
               all_b = std::accumulate(b.begin(), b.end(), 0.0);
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::abs(a[i] / all_a - b[i] / all_b) / 2;
  return sum;
}

}  // namespace firn
