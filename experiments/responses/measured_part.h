// The object of a [[measure]], a boundary contact, a coupling, a boundary or a motion frame, and
// the time span of its stage.
#pragma once

#include <cmath>
#include <initializer_list>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

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
std::string part_group(const Case& c, const Measure& m);

// The records of the object: its samples, if all quantities that are asked for are sampled;
// otherwise the frames.
class PartRecords {
 public:
  // `quantities`: names of has_samples().
  PartRecords(const Recording& recording, const Case& c, const Measure& m,
              std::initializer_list<std::string_view> quantities);

  bool are_samples() const { return samples_; }
  // s, of the rows. Loads are means over the interval from the row before; the first row ends none.
  const std::vector<double>& times() const { return times_; }
  // Row by row.
  std::vector<double> rows(std::string_view name) const;
  // Only the last row may follow the one before it sooner than others do. Number of rows without
  // such a one.
  std::size_t regular_rows() const;
  // s, between regular rows. At least two rows.
  double interval() const;

 private:
  const Recording& recording_;
  std::string group_;  // path in the results file, with a slash at the end
  bool samples_ = false;
  std::vector<double> times_;
};

struct MeasuredSpan {
  double start = 0, end = std::numeric_limits<double>::infinity();  // s
  bool includes(double time) const { return time >= start && time <= end; }
};

// Of the named stage, or of the whole run without a name; includes no time if the stage never came.
// Times of stages are whole steps, those of frames and samples too.
inline MeasuredSpan measured_span(const Recording& recording, const std::string& stage) {
  if (stage.empty()) return {};
  for (const StageRecord& s : recording.stages())
    if (s.name == stage)
      return {s.start - 1e-9, std::isnan(s.end) ? MeasuredSpan{}.end : s.end + 1e-9};
  return {std::numeric_limits<double>::infinity(), 0};
}

}  // namespace firn
