#include "experiments/responses/above_responses.h"

#include <fmt/format.h>

#include "experiments/responses/measured_part.h"
#include "experiments/results/results_file.h"

namespace firn {

std::vector<Response> above_responses(const Recording& recording, const Case& c) {
  std::vector<Response> out;
  const std::vector<double> times = recording.frame_times();
  for (const Measure& m : c.measures) {
    if (m.kind != Measure::Kind::above) continue;
    const MeasuredSpan span = measured_span(recording, m.stage);
    std::size_t frames = times.size();
    while (frames > 0 && !span.includes(times[frames - 1])) --frames;
    if (frames == 0) continue;
    const std::string when =
        "in the last frame" + (m.stage.empty() ? "" : fmt::format(" of stage \"{}\"", m.stage));
    const auto add = [&](const std::string& name, const char* unit, const char* what) {
      const double value = recording.series(part_group(c, m) + name).at(frames - 1);
      out.push_back({m.prefix() + name,
                     {value},
                     {},
                     unit,
                     fmt::format("{} by contacts with \"{}\" {}", what, m.boundary, when),
                     1});
    };
    add("above_count", "1", "particles pushed up");
    add("below_count", "1", "particles pushed down");
    add("above_force", "N", "upward component of the normal forces on particles pushed up");
  }
  return out;
}

}  // namespace firn
