#include "experiments/analysis/elementary_effects.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <random>

#include "experiments/analysis/random_stream.h"
#include "experiments/analysis/sample_statistics.h"

namespace firn {
namespace {

constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();

// Part of a factor's range that a step covers.
double step_size(std::size_t levels) {
  const std::size_t step = levels / 2;
  return static_cast<double>(step) / static_cast<double>(levels - 1);
}

ElementaryEffects summary_of(const std::vector<double>& effects) {
  ElementaryEffects e{0, kNoValue, kNoValue, kNoValue, kNoValue, kNoValue};
  e.count = static_cast<int>(effects.size());
  if (effects.empty()) return e;
  const double n = static_cast<double>(effects.size());
  e.mean = e.mean_absolute = 0;
  for (const double x : effects) {
    e.mean += x / n;
    e.mean_absolute += std::abs(x) / n;
  }
  if (effects.size() < 2) return e;
  double squares = 0, absolute_squares = 0;
  for (const double x : effects) {
    squares += (x - e.mean) * (x - e.mean);
    absolute_squares += (std::abs(x) - e.mean_absolute) * (std::abs(x) - e.mean_absolute);
  }
  e.standard_deviation = std::sqrt(squares / (n - 1));
  const double half_width = student_factor(n - 1) * std::sqrt(absolute_squares / (n - 1) / n);
  e.lower = std::max(0.0, e.mean_absolute - half_width);
  e.upper = e.mean_absolute + half_width;
  return e;
}

}  // namespace

ScreeningDesign screening_design(const std::vector<std::size_t>& levels, int trajectories,
                                 std::uint64_t seed) {
  ScreeningDesign design;
  design.levels = levels;
  std::mt19937_64 random(seed);
  std::map<std::vector<std::size_t>, std::size_t> known;
  const auto number_of = [&](const std::vector<std::size_t>& point) {
    const auto [found, added] = known.try_emplace(point, design.points.size());
    if (added) design.points.push_back(point);
    return found->second;
  };
  for (int t = 0; t < trajectories; ++t) {
    std::vector<std::size_t> point, order(levels.size());
    for (const std::size_t n : levels) point.push_back(random_below_by_scaling(random, n));
    std::iota(order.begin(), order.end(), std::size_t{0});
    for (std::size_t i = order.size(); i > 1; --i)
      std::swap(order[i - 1], order[random_below_by_scaling(random, i)]);
    std::vector<ScreeningStep>& steps = design.trajectories.emplace_back();
    std::size_t here = number_of(point);
    for (const std::size_t factor : order) {
      const std::size_t half = levels[factor] / 2;
      const bool rises = point[factor] < half;
      point[factor] = rises ? point[factor] + half : point[factor] - half;
      const std::size_t next = number_of(point);
      steps.push_back({factor, rises ? here : next, rises ? next : here});
      here = next;
    }
  }
  return design;
}

std::vector<ElementaryEffects> elementary_effects(const ScreeningDesign& design,
                                                  std::span<const double> y) {
  std::vector<std::vector<double>> effects(design.levels.size());
  for (const std::vector<ScreeningStep>& steps : design.trajectories)
    for (const ScreeningStep& s : steps) {
      const double effect = (y[s.upper] - y[s.lower]) / step_size(design.levels[s.factor]);
      if (std::isfinite(effect)) effects[s.factor].push_back(effect);
    }
  std::vector<ElementaryEffects> result;
  result.reserve(effects.size());
  for (const std::vector<double>& of_factor : effects) result.push_back(summary_of(of_factor));
  return result;
}

std::vector<double> noise_effects(const ScreeningDesign& design, double standard_error) {
  std::vector<double> result;
  result.reserve(design.levels.size());
  // Mean absolute value of a normal deviate with the variance of a difference.
  const double difference = 2 / std::sqrt(std::numbers::pi) * standard_error;
  for (const std::size_t n : design.levels) result.push_back(difference / step_size(n));
  return result;
}

}  // namespace firn
