// Responses: quantities of a run that calibration and validation compare with measurements.
#pragma once

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

namespace firn {

// Value of a response that is undefined in a run.
inline constexpr double kUndefined = std::numeric_limits<double>::quiet_NaN();

struct Response {
  std::string name;                 // e.g. "angle_of_repose_left"
  std::vector<double> value;        // one entry for a scalar
  std::vector<double> uncertainty;  // one standard deviation each; empty: not known
  std::string unit;                 // "deg", "1", "kg", "s", ...
  std::string method;               // the estimator, e.g. "robust line through the mesh surface"
  int method_version = 1;           // incremented when results of the estimator change
};

// Part of the name of a response: `text`, such as the name of a boundary, with _ for each space.
inline std::string response_name(std::string text) {
  std::ranges::replace(text, ' ', '_');
  return text;
}

}  // namespace firn
