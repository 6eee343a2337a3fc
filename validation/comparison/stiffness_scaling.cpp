#include "validation/comparison/stiffness_scaling.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "experiments/analysis/power_law.h"
#include "experiments/analysis/sample_statistics.h"
#include "experiments/responses/response_expression.h"
#include "experiments/text/number_text.h"

namespace firn {
namespace {

constexpr double trusted_reach = 3;  // beyond this factor an extrapolation is not reliable
constexpr int least_runs = 3, least_stiffnesses = 3;
// An interval that spans a larger factor is no extrapolation.
constexpr double widest = 10;

void add_point(const RunGroup& group, const std::string& operand, double modulus,
               StiffnessScalingResult& s) {
  std::vector<double> values = group.values(operand);
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  if (values.empty()) return;
  const SampleStatistics f = sample_statistics(values);
  s.modulus.push_back(modulus);
  s.mean.push_back(f.mean);
  s.error.push_back(f.error());
  s.runs.push_back(f.count);
}

bool known(const StiffnessScalingResult& s) { return std::isfinite(s.exponent_error); }

std::string interpretation_of(const StiffnessScalingResult& s) {
  if (s.modulus.size() < least_stiffnesses)
    return "two stiffnesses give a slope and no idea of how straight it is";
  if (!known(s)) return "not enough data for an exponent: one run gives no scatter";
  if (s.exponent + 2 * s.exponent_error > -0.05 && s.exponent - 2 * s.exponent_error < 0.05 &&
      std::abs(s.exponent) < 0.05)
    return "does not depend on the stiffness as far as it was examined";
  if (!std::isfinite(s.extrapolated.low))
    return fmt::format("not enough data to extrapolate to {:.3g} times the largest stiffness: {}",
                       s.extrapolation_factor,
                       std::ranges::min(s.runs) < least_runs
                           ? fmt::format("expected {} runs or more at each", least_runs)
                           : fmt::format("the interval spans more than a factor of {}", widest));
  if (s.extrapolation_factor > trusted_reach)
    return fmt::format(
        "the real stiffness is {:.3g} times beyond what was simulated: a direction, "
        "not a value",
        s.extrapolation_factor);
  return "can be extrapolated";
}

void fit(StiffnessScalingResult& s, double real_modulus) {
  const PowerLaw law = fit_power_law(s.modulus, s.mean, s.error, s.runs);
  s.exponent = law.exponent;
  s.exponent_error = law.exponent_error;
  if (!known(s) || s.modulus.size() < least_stiffnesses || std::ranges::min(s.runs) < least_runs)
    return;
  const auto [mid, error] = law.at(real_modulus);
  const double k = student_factor(law.degrees_of_freedom);
  if (2 * k * error > std::log(widest)) return;
  s.extrapolated = {std::exp(mid - k * error), std::exp(mid + k * error)};
}

}  // namespace

StiffnessScalingResult fit_stiffness_scaling(const std::string& operand, const ComparisonRuns& e,
                                             double real_modulus) {
  StiffnessScalingResult s;
  s.response = operand;
  s.exponent = s.exponent_error = std::numeric_limits<double>::quiet_NaN();
  s.extrapolated = {s.exponent, s.exponent};
  for (const JobResult* r : e.base->finished())
    s.unit = unit_of(parse_response_expression(operand), r->responses);
  std::vector<std::pair<double, const RunGroup*>> groups = {{e.base_modulus, e.base}};
  for (const RunGroup* group : e.stiffness) groups.emplace_back(group->setting, group);
  std::ranges::sort(groups, {}, [](const auto& g) { return g.first; });
  for (const auto& [modulus, group] : groups) add_point(*group, operand, modulus, s);
  if (s.modulus.empty()) {
    s.interpretation = "no run gave it";
    return s;
  }
  s.extrapolation_factor = real_modulus / s.modulus.back();
  if (!has_power_law(s.modulus, s.mean)) {
    s.interpretation = "has no power law: it is not above zero at two stiffnesses or more";
    return s;
  }
  fit(s, real_modulus);
  s.interpretation = interpretation_of(s);
  return s;
}

std::string stiffness_scaling_headline(const std::vector<StiffnessScalingResult>& all,
                                       double real_modulus) {
  std::string text;
  for (const StiffnessScalingResult& s : all) {
    if (!std::isfinite(s.exponent)) continue;
    text += fmt::format("{}{} grows as E^({})", text.empty() ? "" : ", ", s.response,
                        measured_text(s.exponent, s.exponent_error));
  }
  if (text.empty()) return "nothing can be said about the stiffness";
  return fmt::format("{}; ice has {:.3g} GPa", text, real_modulus * 1e-9);
}

}  // namespace firn
