// A curve against a curve.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "experiments/text/units.h"
#include "validation/comparison/comparison_kinds.h"

namespace firn::comparison {
namespace {

// The values of a response in another unit of the same kind; nothing for another kind.
std::optional<std::vector<double>> in_unit(const Response& response, const std::string& unit) {
  if (response.unit == unit) return response.value;
  const Unit from = parse_unit(response.unit), to = parse_unit(unit);
  if (from.dimension != to.dimension) return std::nullopt;
  std::vector<double> values = response.value;
  for (double& value : values) value *= from.factor / to.factor;
  return values;
}

// One curve a run: NAME_curve_x and NAME_curve_y of its responses, in the units of the measurement.
std::vector<SampledCurve> curves_of(const RunGroup& base, const MeasuredData& data) {
  std::vector<SampledCurve> curves;
  for (const JobResult* run : base.finished()) {
    const auto find = [&](const char* end, const std::string& unit) {
      const std::string name = data.response + end;
      const auto found = std::ranges::find(run->responses, name, &Response::name);
      if (found != run->responses.end()) {
        if (const auto values = in_unit(*found, unit)) return *values;
      }
      throw InputError(fmt::format(
          "{}: response: \"{}\" in \"{}\" is none of the case's; expected the name of a "
          "[[measure]] of the kind \"curve\", in units of the same kind",
          data.file, name, unit));
    };
    curves.push_back({find("_curve_x", data.x_unit), find("_curve_y", data.unit)});
  }
  return curves;
}

void judge(double tolerance, Comparison& c) {
  const CurveComparison& v = *c.curve;
  const double off = v.difference, expanded = v.expanded;
  c.headline = fmt::format(
      "root mean square difference {:.2g} % of the measured range, +- {:.2g} %; largest {:.2g} % "
      "at "
      "{:.3g} {}",
      100 * off, 100 * expanded, 100 * v.largest, v.at, v.x_unit);
  if (v.runs < 2) {
    c.recommended_action = "more than one run";
    return;
  }
  if (tolerance <= 0) {
    c.verdict = ValidationVerdict::not_judged;
    c.caveats.emplace_back("no tolerance says what difference would matter");
  } else if (off + expanded <= tolerance) {
    c.verdict = ValidationVerdict::consistent;
  } else if (off - expanded > tolerance) {
    c.verdict = ValidationVerdict::inconsistent;
  } else {
    c.recommended_action = v.repeats < 2 ? "repeats of the experiment: one curve gives no scatter"
                                         : "more runs with other seeds and more repeats";
  }
}

}  // namespace

void compare_curve(const SuiteComparison& what, const ComparisonRuns& e, Comparison& c) {
  const MeasuredData& data = *what.measurement.data;
  const std::vector<SampledCurve> simulated = curves_of(*e.base, data);
  c.curve = compare_curves(simulated, data.repeats, data.align);
  if (c.curve) {
    c.curve->x_name = data.x_name;
    c.curve->x_unit = data.x_unit;
    c.curve->y_name = data.y_name;
    c.curve->y_unit = data.unit;
  }
  if (!data.present) {
    c.headline = "the experiment's curve is not here";
    c.recommended_action = fmt::format("its samples, as {}", data.file);
    return;
  }
  if (!c.curve) {
    c.headline = simulated.empty() ? "no run gave a curve" : "the curves have no x in common";
    c.recommended_action = "curves over the same x";
    return;
  }
  if (c.curve->repeats < 2)
    c.caveats.emplace_back("one measured curve: its scatter is taken as that of the runs");
  judge(what.tolerance.value_or(0), c);
}

}  // namespace firn::comparison
