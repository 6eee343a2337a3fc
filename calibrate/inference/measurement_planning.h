// What to measure next: how much each measurement that could be made would teach.
#pragma once

#include <vector>

#include "calibrate/inference/identifiability.h"

namespace firn {

struct MeasurementValue {
  ResponseId response;
  bool repeats_a_target = false;  // the same measurement once more
  double uncertainty = 0;         // one standard deviation of it, in `unit`
  std::string unit;
  double effort = 0;       // s of work; 0: not said
  double information = 0;  // bits expected about the parameters
  // Expected standard deviation along the posterior's longest direction, as a share of today's.
  double remaining_extent = 1;
  double discrepancy = 0;  // one standard deviation of the simulator's systematic error, in `unit`
};

// Every target, measured once more, and every observed response whose measurement the study
// describes; first what shortens the posterior's longest direction most for its effort (without
// efforts: what shortens it most).
//
// Information is the mutual information of the outcome and the parameters (Lindley 1956), by nested
// Monte Carlo over the posterior (Ryan 2003) with the surrogate's own uncertainty counted as part
// of the measurement's. A repeated measurement meets the same error of the surrogate and the
// same discrepancy as the first one. Deterministic.
std::vector<MeasurementValue> rank_measurements(const Study& study, const ResponseModels& knowledge,
                                                const Posterior& posterior);

}  // namespace firn
