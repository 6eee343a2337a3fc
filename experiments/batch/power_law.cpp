#include "experiments/batch/power_law.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace firn {

namespace {

constexpr double least_relative_error = 0.02;

}  // namespace

bool has_power_law(std::span<const double> x, std::span<const double> mean) {
  const auto above_zero = [](double v) { return v > 0 && std::isfinite(v); };
  return std::ranges::all_of(x, above_zero) && std::ranges::all_of(mean, above_zero) &&
         std::ranges::any_of(x, [&](double v) { return v != x.front(); });
}

PowerLaw fit_power_law(std::span<const double> x, std::span<const double> mean,
                       std::span<const double> error) {
  const std::size_t n = x.size();
  std::vector<double> u(n), v(n), weight(n);
  double total = 0, sum_u = 0, sum_v = 0;
  for (std::size_t i = 0; i < n; ++i) {
    u[i] = std::log(x[i]);
    v[i] = std::log(mean[i]);
    const double relative =
        std::hypot(std::isfinite(error[i]) ? error[i] / mean[i] : 0, least_relative_error);
    weight[i] = 1 / (relative * relative);
    total += weight[i];
    sum_u += weight[i] * u[i];
    sum_v += weight[i] * v[i];
  }
  PowerLaw law;
  law.centre = sum_u / total;
  law.height = sum_v / total;
  double uu = 0, uv = 0;
  for (std::size_t i = 0; i < n; ++i) {
    uu += weight[i] * (u[i] - law.centre) * (u[i] - law.centre);
    uv += weight[i] * (u[i] - law.centre) * (v[i] - law.height);
  }
  law.exponent = uv / uu;
  law.degrees_of_freedom = static_cast<int>(n) - 2;
  if (law.degrees_of_freedom < 1) return law;
  double misfit = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double rest = v[i] - law.height - law.exponent * (u[i] - law.centre);
    misfit += weight[i] * rest * rest;
  }
  const double scale = std::max(1.0, misfit / law.degrees_of_freedom);
  law.exponent_error = std::sqrt(scale / uu);
  law.height_error = std::sqrt(scale / total);
  return law;
}

PowerLaw::Logarithm PowerLaw::at(double x) const {
  const double away = std::log(x) - centre;
  return {height + exponent * away, std::hypot(height_error, exponent_error * away)};
}

}  // namespace firn
