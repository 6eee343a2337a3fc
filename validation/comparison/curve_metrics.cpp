#include "validation/comparison/curve_metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "experiments/results/response.h"
#include "validation/statistics/distributions.h"
#include "validation/statistics/estimated_variance.h"

namespace firn {
namespace {

constexpr std::size_t grid_points = 200;

void move(SampledCurve& curve, double by) {
  for (double& x : curve.x) x += by;
}

SampledCurve mean_of(const std::vector<SampledCurve>& curves, const std::vector<double>& x) {
  SampledCurve mean{x, {}};
  for (const double at : x) {
    double sum = 0;
    for (const SampledCurve& c : curves) sum += curve_at(c, at);
    mean.y.push_back(sum / static_cast<double>(curves.size()));
  }
  return mean;
}

// Standard error of the mean.
double error_at(const std::vector<SampledCurve>& curves, double x) {
  std::vector<double> values;
  values.reserve(curves.size());
  for (const SampledCurve& c : curves) values.push_back(curve_at(c, x));
  return sample_statistics(values).error();
}

double mean_square(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v * v;
  return sum / static_cast<double>(values.size());
}

// Of the difference of the means, as if each curve were off by the same everywhere. A single
// measured curve scatters as runs do; a single run gives no noise at all.
Noise noise_of(const CurveComparison& c) {
  Noise noise;
  if (c.runs > 1)
    noise.add({mean_square(c.simulated_error), c.runs - 1.0}, c.repeats == 1 ? 1.0 + c.runs : 1.0);
  if (c.repeats > 1) noise.add({mean_square(c.measured_error), c.repeats - 1.0});
  return noise;
}

double span(const SampledCurve& c) { return c.x.back() - c.x.front(); }

// Where all of them reach.
std::vector<double> common_grid(const std::vector<SampledCurve>& a,
                                const std::vector<SampledCurve>& b) {
  double low = -std::numeric_limits<double>::infinity(), high = -low;
  for (const auto* curves : {&a, &b})
    for (const SampledCurve& c : *curves) {
      low = std::max(low, c.x.front());
      high = std::min(high, c.x.back());
    }
  std::vector<double> x;
  for (std::size_t k = 0; low < high && k < grid_points; ++k)
    x.push_back(low + (high - low) * static_cast<double>(k) / (grid_points - 1));
  return x;
}

// Mean square difference of a curve that is shifted, where both reach; nothing where that is less
// than half of the shorter one.
std::optional<double> misfit(const SampledCurve& curve, double shift, const SampledCurve& other) {
  const double low = std::max(curve.x.front() + shift, other.x.front());
  const double high = std::min(curve.x.back() + shift, other.x.back());
  if (high - low < 0.5 * std::min(span(curve), span(other))) return std::nullopt;
  double sum = 0;
  for (std::size_t k = 0; k < grid_points; ++k) {
    const double x = low + (high - low) * static_cast<double>(k) / (grid_points - 1);
    const double d = curve_at(curve, x - shift) - curve_at(other, x);
    sum += d * d;
  }
  return sum / grid_points;
}

}  // namespace

double curve_at(const SampledCurve& c, double x) {
  const auto next = std::ranges::upper_bound(c.x, x);
  if (next == c.x.begin()) return c.y.front();
  if (next == c.x.end()) return c.y.back();
  const auto i = static_cast<std::size_t>(next - c.x.begin());
  const double share = (x - c.x[i - 1]) / (c.x[i] - c.x[i - 1]);
  return c.y[i - 1] + share * (c.y[i] - c.y[i - 1]);
}

SampledCurve in_order(SampledCurve curve) {
  std::vector<std::size_t> order(curve.x.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return curve.x[i]; });
  SampledCurve sorted;
  for (const std::size_t i : order) {
    if (!std::isfinite(curve.x[i]) || !std::isfinite(curve.y[i])) continue;
    if (!sorted.x.empty() && curve.x[i] == sorted.x.back()) continue;
    sorted.x.push_back(curve.x[i]);
    sorted.y.push_back(curve.y[i]);
  }
  return sorted;
}

SampledCurve from_onset(SampledCurve curve, double share) {
  double largest = 0;
  for (const double y : curve.y) largest = std::max(largest, std::abs(y));
  for (std::size_t i = 0; i < curve.y.size(); ++i) {
    if (std::abs(curve.y[i]) < share * largest) continue;
    move(curve, -curve.x[i]);
    break;
  }
  return curve;
}

double best_shift(const SampledCurve& curve, const SampledCurve& other) {
  // A coarse search over all shifts, then a finer one about the best.
  const double first = other.x.front() - curve.x.back(), last = other.x.back() - curve.x.front();
  double best = 0, step = (last - first) / 400;
  std::optional<double> least;
  const auto look = [&](double from, double to) {
    for (double shift = from; shift <= to; shift += step)
      if (const auto m = misfit(curve, shift, other); m && (!least || *m < *least)) {
        least = m;
        best = shift;
      }
  };
  look(first, last);
  for (int round = 0; round < 3; ++round) {
    const double about = best, reach = step;
    step /= 20;
    look(about - reach, about + reach);
  }
  return best;
}

std::optional<CurveComparison> compare_curves(std::vector<SampledCurve> simulated,
                                              std::vector<SampledCurve> measured,
                                              MeasuredData::Alignment align) {
  CurveComparison c;
  for (auto* curves : {&simulated, &measured}) {
    for (SampledCurve& one : *curves) {
      one = in_order(std::move(one));
      if (align == MeasuredData::Alignment::onset && !one.x.empty()) one = from_onset(one);
    }
    std::erase_if(*curves, [](const SampledCurve& one) { return one.x.size() < 2; });
  }
  if (simulated.empty()) return std::nullopt;
  if (align == MeasuredData::Alignment::best && !measured.empty()) {
    const SampledCurve reference = measured.front();
    for (std::size_t i = 1; i < measured.size(); ++i)
      move(measured[i], best_shift(measured[i], reference));
    for (SampledCurve& one : simulated) {
      const double shift = best_shift(one, reference);
      move(one, shift);
      c.shift += shift / static_cast<double>(simulated.size());
    }
  }
  c.x = common_grid(simulated, measured);
  if (c.x.empty()) return std::nullopt;
  c.runs = static_cast<int>(simulated.size());
  c.repeats = static_cast<int>(measured.size());
  c.simulated = mean_of(simulated, c.x).y;
  for (const double x : c.x) c.simulated_error.push_back(error_at(simulated, x));
  if (measured.empty()) {
    c.range = c.difference = c.uncertainty = c.expanded = c.largest = c.at = kUndefined;
    return c;
  }
  c.measured = mean_of(measured, c.x).y;
  const auto [low, high] = std::ranges::minmax(c.measured);
  c.range = high - low;
  double squares = 0;
  for (std::size_t k = 0; k < c.x.size(); ++k) {
    c.measured_error.push_back(error_at(measured, c.x[k]));
    const double d = c.simulated[k] - c.measured[k];
    squares += d * d;
    if (std::abs(d) > std::abs(c.largest)) {
      c.largest = d;
      c.at = c.x[k];
    }
  }
  const auto n = static_cast<double>(c.x.size());
  c.difference = std::sqrt(squares / n) / c.range;
  const Noise noise = noise_of(c);
  c.uncertainty = std::sqrt(noise.variance()) / c.range;
  c.expanded = expanded_uncertainty(noise) / c.range;
  c.largest /= c.range;
  return c;
}

}  // namespace firn
