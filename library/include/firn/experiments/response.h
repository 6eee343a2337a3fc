// A response: a quantity measured from a run. docs/responses.md says how each one is measured.
#pragma once

#include <string>
#include <vector>

namespace firn::experiments {

struct Response {
  std::string name;                 // "angle_of_repose_left"
  std::vector<double> value;        // one entry for a scalar; NaN: undefined in this run
  std::vector<double> uncertainty;  // one standard deviation each; empty: not known
  std::string unit;                 // "deg", "kg", "s"; "1" for a number
  std::string method;               // the estimator in words
};

// The current name for an earlier one, of which it warns on standard error; any other name stays.
std::string current_response_name(const std::string& name);

}  // namespace firn::experiments
