#include "validation/softening.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "experiments/batch/operand.h"

namespace firn {
namespace {

constexpr double undefined = std::numeric_limits<double>::quiet_NaN();
constexpr double trusted_reach = 3;      // beyond this factor an extrapolation is a guess
constexpr double least_relative = 0.02;  // error of a mean of few seeds that happen to agree

void add_point(const RunGroup& group, const std::string& operand, double modulus,
               SofteningResult& s) {
  std::vector<double> values = group.values(operand);
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  if (values.empty()) return;
  const SampleFacts f = facts_of(values);
  s.modulus.push_back(modulus);
  s.mean.push_back(f.mean);
  s.error.push_back(f.error());
}

std::string word_on(const SofteningResult& s) {
  if (s.modulus.size() < 3) return "two stiffnesses give a slope and no idea of how straight it is";
  if (s.exponent + 2 * s.exponent_error > -0.05 && s.exponent - 2 * s.exponent_error < 0.05 &&
      std::abs(s.exponent) < 0.05)
    return "does not depend on the stiffness as far as it was looked at";
  if (s.reach > trusted_reach)
    return fmt::format(
        "the real stiffness is {:.3g} times beyond what was simulated: a direction, "
        "not a value",
        s.reach);
  return "can be extrapolated";
}

// Weighted least squares of ln(mean) over ln(modulus).
void fit(SofteningResult& s, double real_modulus) {
  double w0 = 0, wx = 0, wy = 0, wxx = 0, wxy = 0;
  const std::size_t n = s.modulus.size();
  std::vector<double> x(n), y(n), w(n);
  for (std::size_t i = 0; i < n; ++i) {
    x[i] = std::log(s.modulus[i]);
    y[i] = std::log(s.mean[i]);
    const double relative =
        std::hypot(std::isfinite(s.error[i]) ? s.error[i] / s.mean[i] : 0, least_relative);
    w[i] = 1 / (relative * relative);
    w0 += w[i];
    wx += w[i] * x[i];
    wy += w[i] * y[i];
    wxx += w[i] * x[i] * x[i];
    wxy += w[i] * x[i] * y[i];
  }
  const double determinant = w0 * wxx - wx * wx;
  s.exponent = (w0 * wxy - wx * wy) / determinant;
  const double constant = (wy - s.exponent * wx) / w0;
  double misfit = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double rest = y[i] - constant - s.exponent * x[i];
    misfit += w[i] * rest * rest;
  }
  if (n < 3) return;
  // A line that misses by more than the errors say is no better known than it misses.
  const double freedom = static_cast<double>(n) - 2;
  const double scale = std::max(1.0, misfit / freedom);
  s.exponent_error = std::sqrt(scale * w0 / determinant);
  const double at = std::log(real_modulus), centre = wx / w0;
  const double error =
      std::sqrt(scale * (1 / w0 + (at - centre) * (at - centre) * w0 / determinant));
  const double mid = constant + s.exponent * at, k = student_factor(freedom);
  s.extrapolated = {std::exp(mid - k * error), std::exp(mid + k * error)};
}

}  // namespace

SofteningResult soften(const std::string& operand, const Evidence& e, double real_modulus) {
  SofteningResult s;
  s.response = operand;
  s.exponent = s.exponent_error = undefined;
  s.extrapolated = {undefined, undefined};
  for (const JobResult* r : e.base->finished())
    s.unit = unit_of(parse_operand(operand), r->responses);
  std::vector<std::pair<double, const RunGroup*>> groups = {{e.base_modulus, e.base}};
  for (const RunGroup* group : e.stiffness) groups.emplace_back(group->setting, group);
  std::ranges::sort(groups, {}, [](const auto& g) { return g.first; });
  for (const auto& [modulus, group] : groups) add_point(*group, operand, modulus, s);
  if (s.modulus.empty()) {
    s.word = "no run gave it";
    return s;
  }
  s.reach = real_modulus / s.modulus.back();
  if (s.modulus.size() < 2 || std::ranges::any_of(s.mean, [](double m) { return !(m > 0); })) {
    s.word = "has no power law: it is not above zero at two stiffnesses or more";
    return s;
  }
  fit(s, real_modulus);
  s.word = word_on(s);
  return s;
}

std::string softening_headline(const std::vector<SofteningResult>& all, double real_modulus) {
  std::string text;
  for (const SofteningResult& s : all) {
    if (!std::isfinite(s.exponent)) continue;
    text += fmt::format("{}{} grows as E^{:.2f}", text.empty() ? "" : ", ", s.response, s.exponent);
    if (std::isfinite(s.exponent_error)) text += fmt::format(" (+- {:.2f})", s.exponent_error);
  }
  if (text.empty()) return "nothing can be said about the stiffness";
  return fmt::format("{}; ice has {:.3g} GPa", text, real_modulus * 1e-9);
}

}  // namespace firn
