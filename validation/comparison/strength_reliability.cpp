#include "validation/comparison/strength_reliability.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <numeric>

#include "experiments/system/value_place.h"
#include "firn/math.h"

namespace firn {
namespace {

constexpr int shapes = 120, scales = 120;           // points of the grid
constexpr double least_shape = 1, most_shape = 60;  // a coefficient of variation of 100 % ... 2 %

using Cdf = std::function<double(double)>;

struct Breakage {
  double each = 0, any = 0;
};

Breakage breakage(const std::vector<std::vector<double>>& runs, const Cdf& strength) {
  Breakage d;
  double particles = 0;
  for (const std::vector<double>& loads : runs) {
    double none = 1;
    for (const double load : loads) {
      const double p = strength(load);
      d.each += p;
      none *= 1 - p;
      particles += 1;
    }
    d.any += (1 - none) / static_cast<double>(runs.size());
  }
  d.each /= particles;
  return d;
}

// Mean and variance of a Weibull variable between two bounds, by the midpoint rule in probability.
struct Moments {
  double mean = 0, variance = 0;
};
Moments between(double shape, double scale, double low, double high) {
  const auto cdf = [&](double x) { return -std::expm1(-std::pow(x / scale, shape)); };
  const double from = cdf(low), to = cdf(high);
  constexpr int points = 64;
  double sum = 0, squares = 0;
  for (int i = 0; i < points; ++i) {
    const double p = from + (to - from) * (i + 0.5) / points;
    const double x = std::clamp(scale * std::pow(-std::log1p(-p), 1 / shape), low, high);
    sum += x / points;
    squares += x * x / points;
  }
  return {sum, std::max(squares - sum * sum, 1e-12 * sum * sum)};
}

double log_density(double x, double shape, double scale) {
  return std::log(shape / scale) + (shape - 1) * std::log(x / scale) - std::pow(x / scale, shape);
}

double log_likelihood(const Measurement& m, double shape, double scale) {
  double sum = 0;
  if (m.scatter == ScatterKind::values) {
    for (const double v : m.values) sum += log_density(v, shape, scale);
    return sum;
  }
  // Joint density of smallest and largest of n, times that of the mean of those between, which is
  // near enough to normal.
  const auto survival = [&](double x) { return std::exp(-std::pow(x / scale, shape)); };
  sum = log_density(m.minimum, shape, scale) + log_density(m.maximum, shape, scale);
  const int inner = m.repeats - 2;
  if (inner < 1) return sum;
  sum += inner * std::log(std::max(survival(m.minimum) - survival(m.maximum), 1e-300));
  const double mean = (m.repeats * m.value - m.minimum - m.maximum) / inner;
  const Moments inside = between(shape, scale, m.minimum, m.maximum);
  const double variance = inside.variance / inner;
  return sum - 0.5 * std::log(2 * std::numbers::pi * variance) -
         0.5 * (mean - inside.mean) * (mean - inside.mean) / variance;
}

void require_strength(const Measurement& m) {
  const bool has_range = m.scatter == ScatterKind::values || m.scatter == ScatterKind::range;
  if (has_range && m.minimum > 0) return;
  throw InputError(place_or_file(m.value_place, m.file) +
                   ": has no range of breaking forces above zero; expected values, or a scatter of "
                   "the kind \"range\"");
}

}  // namespace

BreakageProbability breakage_distribution_free(const std::vector<std::vector<double>>& runs,
                                               const Measurement& m) {
  require_strength(m);
  const DistributionBand band =
      with_place(m.value_place, [&] { return distribution_of(m).value(); });
  const double width = distribution_band_width(m.repeats);
  const Breakage least =
      breakage(runs, [&](double load) { return std::max(0.0, band.at(load).low - width); });
  const Breakage most = breakage(
      runs, [&](double load) { return load > 0 ? std::min(1.0, band.at(load).high + width) : 0; });
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  return {{least.each, most.each}, {least.any, most.any}, none, none};
}

WeibullFit fit_weibull(const Measurement& m) {
  require_strength(m);
  WeibullFit fit;
  std::vector<double> log_weight;
  for (int i = 0; i < shapes; ++i)
    for (int j = 0; j < scales; ++j) {
      const double shape = least_shape * std::pow(most_shape / least_shape, (i + 0.5) / shapes);
      // The mean's neighborhood: far wider than its uncertainty.
      const double scale = m.value * (0.7 + 0.8 * (j + 0.5) / scales);
      fit.shape.push_back(shape);
      fit.scale.push_back(scale);
      log_weight.push_back(log_likelihood(m, shape, scale) - std::log(scale));
    }
  const double most = *std::ranges::max_element(log_weight);
  double sum = 0;
  for (const double w : log_weight) {
    fit.weight.push_back(std::exp(w - most));
    sum += fit.weight.back();
  }
  for (double& w : fit.weight) w /= sum;
  const auto shape_at = [&](double q) { return weighted_quantile(fit.shape, fit.weight, q); };
  fit.shape_95 = {shape_at(0.025), shape_at(0.975)};
  fit.shape_median = shape_at(0.5);
  return fit;
}

BreakageProbability breakage_weibull(const std::vector<std::vector<double>>& runs,
                                     const WeibullFit& fit) {
  std::vector<double> each, any, weight;
  for (std::size_t k = 0; k < fit.weight.size(); ++k) {
    if (fit.weight[k] < 1e-7) continue;
    const Breakage d = breakage(runs, [&](double load) {
      return load > 0 ? -std::expm1(-std::pow(load / fit.scale[k], fit.shape[k])) : 0;
    });
    each.push_back(d.each);
    any.push_back(d.any);
    weight.push_back(fit.weight[k]);
  }
  const auto interval = [&](const std::vector<double>& x) {
    return Interval{weighted_quantile(x, weight, 0.025), weighted_quantile(x, weight, 0.975)};
  };
  const auto weighted_mean = [&](const std::vector<double>& x) {
    return std::inner_product(x.begin(), x.end(), weight.begin(), 0.0);
  };
  return {interval(each), interval(any), weighted_mean(each), weighted_mean(any)};
}

}  // namespace firn
