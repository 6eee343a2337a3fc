#include "experiments/analysis/power_law.h"

#include <algorithm>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <vector>

#include "experiments/analysis/sample_statistics.h"

namespace firn {

namespace {

constexpr double least_relative_error = 0.02, level = 0.05;

struct Pooled {
  double variance = 0, freedom = 0;  // relative, of one run
};
Pooled pooled_scatter(std::span<const double> mean, std::span<const double> error,
                      std::span<const int> runs) {
  Pooled p;
  for (std::size_t i = 0; i < mean.size(); ++i) {
    if (runs[i] < 2 || !std::isfinite(error[i])) continue;
    const double relative = error[i] / mean[i];
    p.variance += (runs[i] - 1) * runs[i] * relative * relative;
    p.freedom += runs[i] - 1;
  }
  if (p.freedom > 0) p.variance /= p.freedom;
  return p;
}

// A misfit per degree of freedom that the scatter does not explain.
bool is_bent(double misfit, double freedom, double scatter_freedom) {
  if (scatter_freedom < 1) return true;
  const boost::math::fisher_f f(freedom, scatter_freedom);
  return boost::math::cdf(boost::math::complement(f, misfit)) < level;
}

}  // namespace

bool has_power_law(std::span<const double> x, std::span<const double> mean) {
  const auto above_zero = [](double v) { return v > 0 && std::isfinite(v); };
  return std::ranges::all_of(x, above_zero) && std::ranges::all_of(mean, above_zero) &&
         std::ranges::any_of(x, [&](double v) { return v != x.front(); });
}

PowerLaw fit_power_law(std::span<const double> x, std::span<const double> mean,
                       std::span<const double> error, std::span<const int> runs) {
  const std::size_t n = x.size();
  const Pooled scatter = pooled_scatter(mean, error, runs);
  std::vector<double> u(n), v(n), weight(n);
  double total = 0, sum_u = 0, sum_v = 0;
  for (std::size_t i = 0; i < n; ++i) {
    u[i] = std::log(x[i]);
    v[i] = std::log(mean[i]);
    weight[i] =
        1 / (scatter.variance / std::max(1, runs[i]) + least_relative_error * least_relative_error);
    total += weight[i];
    sum_u += weight[i] * u[i];
    sum_v += weight[i] * v[i];
  }
  PowerLaw law;
  law.center = sum_u / total;
  law.log_mean = sum_v / total;
  double uu = 0, uv = 0;
  for (std::size_t i = 0; i < n; ++i) {
    uu += weight[i] * (u[i] - law.center) * (u[i] - law.center);
    uv += weight[i] * (u[i] - law.center) * (v[i] - law.log_mean);
  }
  law.exponent = uv / uu;
  const auto freedom = static_cast<double>(n) - 2;
  if (freedom < 1) return law;
  double misfit = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double rest = v[i] - law.log_mean - law.exponent * (u[i] - law.center);
    misfit += weight[i] * rest * rest / freedom;
  }
  const bool bent = is_bent(misfit, freedom, scatter.freedom);
  law.degrees_of_freedom = bent ? freedom : scatter.freedom;
  if (law.degrees_of_freedom < 1) return law;
  const double scale = bent ? std::max(1.0, misfit) : 1;
  law.slope_error = std::sqrt(scale / uu);
  law.log_mean_error = std::sqrt(scale / total);
  law.exponent_error = law.slope_error * student_factor(law.degrees_of_freedom, 0.6827);
  return law;
}

PowerLaw::Logarithm PowerLaw::at(double x) const {
  const double away = std::log(x) - center;
  return {log_mean + exponent * away, std::isfinite(exponent_error)
                                          ? std::hypot(log_mean_error, slope_error * away)
                                          : exponent_error};
}

}  // namespace firn
