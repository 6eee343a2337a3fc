// The object of a [[measure]], a boundary contact, a coupling, a boundary or a motion frame, and
// the time span of its stage.
#pragma once

#include <cmath>
#include <limits>
#include <string>

#include "experiments/case/case.h"
#include "experiments/results/results_file.h"

namespace firn {

// Name of the object.
inline std::string measured_part(const Case& c, const Measure& m) {
  if (m.contact >= 0) return c.model.boundary_contacts[static_cast<std::size_t>(m.contact)].name;
  if (m.coupling >= 0) return c.model.couplings[static_cast<std::size_t>(m.coupling)].name;
  return m.boundary.empty() ? c.model.frames[static_cast<std::size_t>(m.frame)].name : m.boundary;
}

// Path of its group in the results file, with a slash at the end.
inline std::string part_group(const Case& c, const Measure& m) {
  const char* group = m.contact >= 0       ? "/boundary_contacts/"
                      : m.coupling >= 0    ? "/couplings/"
                      : m.boundary.empty() ? "/motion_frames/"
                                           : "/boundaries/";
  return group + measured_part(c, m) + "/";
}

struct MeasuredSpan {
  double start = 0, end = std::numeric_limits<double>::infinity();  // s
  bool includes(double time) const { return time >= start && time <= end; }
};

// Of the named stage, or of the whole run without a name; includes no time if the stage never came.
// Times of stages are whole steps, those of frames too.
inline MeasuredSpan measured_span(const Recording& recording, const std::string& stage) {
  if (stage.empty()) return {};
  for (const StageRecord& s : recording.stages())
    if (s.name == stage)
      return {s.start - 1e-9, std::isnan(s.end) ? MeasuredSpan{}.end : s.end + 1e-9};
  return {std::numeric_limits<double>::infinity(), 0};
}

}  // namespace firn
