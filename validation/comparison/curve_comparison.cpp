// A curve against a curve.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "experiments/system/value_place.h"
#include "experiments/text/number_text.h"
#include "experiments/text/units.h"
#include "validation/comparison/comparison_kinds.h"

namespace firn::comparison {

std::vector<SampledCurve> curves_of(const RunGroup& base, const MeasuredData& data) {
  std::vector<SampledCurve> curves;
  for (const JobResult* run : base.finished()) {
    const auto find = [&](const char* end, const std::string& unit) {
      const std::string name = data.response + end;
      if (const auto values = response_values(*run, name, unit)) return *values;
      throw InputError(
          fmt::format("{}: \"{}\" in \"{}\" is none of the case's; expected the name of a "
                      "[[measure]] of the kind \"curve\", in units of the same kind",
                      place_or_file(data.response_place, data.file), name, unit));
    };
    curves.push_back({find("_curve_x", data.x_unit), find("_curve_y", data.unit)});
  }
  return curves;
}

namespace {

void judge(double tolerance, Comparison& c) {
  const CurveComparison& v = *c.curve;
  const double off = v.difference, expanded = v.expanded;
  const double step = (v.x.back() - v.x.front()) / 1000;  // of places that people distinguish
  c.headline =
      fmt::format("root mean square difference {} % of the measured range; largest {} % at {} {}",
                  measured_text(100 * off, 100 * expanded), number_text(100 * v.largest, 2),
                  number_text(std::round(v.at / step) * step, 3), v.x_unit);
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

// What makes most of a difference between curves of one shape: the zero of x, the sign of y, or the
// zero of y. Each is a setting of the recorder and no result.
std::vector<std::string> offset_caveats(const std::vector<SampledCurve>& simulated,
                                        const MeasuredData& data, const CurveComparison& v) {
  constexpr double kNoticed = 0.05, kLeft = 0.5;  // of the range; of the difference
  std::vector<std::string> caveats;
  if (!(v.difference > kNoticed)) return caveats;
  if (data.align == MeasuredData::Alignment::none) {
    const auto best = compare_curves(simulated, data.repeats, MeasuredData::Alignment::best);
    if (best && best->difference < kLeft * v.difference)
      caveats.push_back(fmt::format(
          "with the simulation shifted by {} {} the difference is {} %: where the recorder and the "
          "simulation start at different times, set align = \"onset\" or \"best\" in [data]",
          number_text(best->shift, 3), v.x_unit, number_text(100 * best->difference, 2)));
  }
  double along = 0, offset = 0, squares = 0;
  const auto n = static_cast<double>(v.x.size());
  for (std::size_t i = 0; i < v.x.size(); ++i) {
    along += v.measured[i] * v.simulated[i] / n;
    offset += (v.measured[i] - v.simulated[i]) / n;
  }
  for (std::size_t i = 0; i < v.x.size(); ++i) {
    const double rest = v.measured[i] - v.simulated[i] - offset;
    squares += rest * rest / n;
  }
  if (along < 0)
    caveats.push_back(
        fmt::format("measured and simulated {} have opposite signs: a simulated force is a "
                    "magnitude; invert = true in [data] changes the sign of the measured one",
                    v.y_name));
  else if (v.range > 0 && std::sqrt(squares) / v.range < kLeft * v.difference)
    caveats.push_back(fmt::format(
        "without a constant {} {} the difference is {} %: where the recorder was not set to zero, "
        "set tare or tare_over in [data]",
        number_text(offset, 3), v.y_unit, number_text(100 * std::sqrt(squares) / v.range, 2)));
  return caveats;
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
  for (std::string& caveat : offset_caveats(simulated, data, *c.curve))
    c.caveats.push_back(std::move(caveat));
  judge(what.tolerance.value_or(0), c);
}

}  // namespace firn::comparison
