// From the responses of a run to the public type. Not installed.
#pragma once

#include <vector>

#include "experiments/results/response.h"
#include "firn/experiments/response.h"

namespace firn::experiments {

inline std::vector<Response> public_responses(const std::vector<firn::Response>& responses) {
  std::vector<Response> all;
  for (const firn::Response& r : responses)
    all.push_back({r.name, r.value, r.uncertainty, r.unit, r.method});
  return all;
}

}  // namespace firn::experiments
