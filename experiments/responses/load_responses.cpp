#include "experiments/responses/load_responses.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "experiments/responses/measured_part.h"
#include "experiments/results/results_file.h"

namespace firn {

std::vector<Response> load_responses(const Recording& recording, const Case& c) {
  std::vector<Response> out;
  for (const Measure& m : c.measures) {
    if (m.kind != Measure::Kind::load) continue;
    const std::string part = measured_part(c, m);
    const PartRecords records(recording, c, m, {"force"});
    const std::vector<double>& times = records.times();
    const std::vector<double> rows = records.rows("force");
    const MeasuredSpan span = measured_span(recording, m.stage);
    const bool along = m.direction != Vec3::Zero();
    double impulse = 0, duration = 0, peak = -std::numeric_limits<double>::infinity();
    for (std::size_t i = 1; i < times.size() && 3 * i + 2 < rows.size(); ++i) {
      // An interval begins at the row before. One that two stages share is left out.
      if (!span.includes(times[i - 1]) || !span.includes(times[i])) continue;
      const Vec3 force(rows[3 * i], rows[3 * i + 1], rows[3 * i + 2]);
      const double load = along ? force.dot(m.direction) : force.norm();
      if (std::isnan(load)) continue;  // removed
      impulse += (times[i] - times[i - 1]) * load;
      duration += times[i] - times[i - 1];
      peak = std::max(peak, load);
    }
    if (duration == 0) continue;
    const std::string what = fmt::format(
        "force of {} \"{}\"{}{}", m.coupling >= 0 ? "the coupling" : "contacts on", part,
        along ? fmt::format(" along ({:g}, {:g}, {:g})", m.direction.x(), m.direction.y(),
                            m.direction.z())
              : "",
        m.stage.empty() ? "" : fmt::format(" in stage \"{}\"", m.stage));
    out.push_back({m.name + "_load_mean", {impulse / duration}, {}, "N", what + ", mean", 1});
    out.push_back({m.name + "_load_peak",
                   {peak},
                   {},
                   "N",
                   fmt::format("{}, largest mean over {}", what,
                               records.are_samples() ? "a sample" : "an output frame"),
                   1});
  }
  return out;
}

}  // namespace firn
