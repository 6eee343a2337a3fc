// A measured response: what calibration and validation compare with experiment.
#pragma once

#include <limits>
#include <string>
#include <vector>

namespace firn {

class Recording;
struct Case;

// The value of a response that a run leaves undefined.
inline constexpr double kUndefined = std::numeric_limits<double>::quiet_NaN();

struct Response {
  std::string name;                 // e.g. "angle_of_repose_left"
  std::vector<double> value;        // a scalar has one entry
  std::vector<double> uncertainty;  // one standard deviation each; empty: not known
  std::string unit;                 // "deg", "1", "kg", "s", ...
  std::string method;               // the estimator, e.g. "robust line through the mesh surface"
  int method_version = 1;           // raised whenever the estimator's numbers change
};

// All responses that the case of the recording requests, computed from the recording alone.
std::vector<Response> measure(const Recording& recording);
// The same with the case of the file, for callers that have constructed it.
std::vector<Response> measure(const Recording& recording, const Case& c);

}  // namespace firn
