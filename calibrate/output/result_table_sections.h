// Sections of the text table of a study, for result_table.cpp alone.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "calibrate/output/calibration_result.h"
#include "calibrate/study/study_file.h"

namespace firn::result_table {

using Out = fmt::memory_buffer;

// Width of the column of responses.
inline int label_width(const Study& study) {
  std::size_t width = 22;
  for (const Target& t : study.targets) width = std::max(width, t.response.label.size());
  for (const Observed& o : study.observed) width = std::max(width, o.response.label.size());
  return static_cast<int>(width);
}

// ", discrepancy 1.5" where there is one.
inline std::string discrepancy_share(const VarianceSplit& s, const char* format) {
  if (!(s.discrepancy > 0)) return "";
  return ", discrepancy " + fmt::format(fmt::runtime(format), std::sqrt(s.discrepancy));
}

// How the responses were modeled, and what they depend on.
void print_models(Out& out, const Study& study, const CalibrationResult& a);
void print_sensitivity(Out& out, const Study& study, const CalibrationResult& a);
void print_numerics(Out& out, const Study& study, const CalibrationResult& a);
void print_fidelity(Out& out, const Study& study, const CalibrationResult& a);

// Parameters and combinations, and what determines them.
void print_identified(Out& out, const Study& study, const CalibrationResult& a);

}  // namespace firn::result_table
