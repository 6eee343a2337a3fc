// Which measurement to make next: the expected information of each possible measurement.
#pragma once

#include <vector>

#include "calibrate/inference/identifiability.h"

namespace firn {

struct MeasurementValue {
  ResponseId response;
  bool repeats_a_target = false;  // a repeat of a measurement that is a target
  double uncertainty = 0;         // one standard deviation of it, in `unit`
  std::string unit;
  double effort = 0;       // s of work; 0: not stated
  double information = 0;  // bits expected about the parameters
  // Expected standard deviation along the posterior's longest direction, relative to the present
  // one.
  double remaining_extent = 1;
  double discrepancy = 0;  // one standard deviation of the simulator's systematic error, in `unit`
};

// Repeats of every target, and measurements of every observed response that the study describes.
// Sorted by the expected narrowing of the longest direction of the posterior per effort (without
// efforts: by the narrowing).
//
// Information is the mutual information of the outcome and the parameters (Lindley 1956), by nested
// Monte Carlo over the posterior (Ryan 2003) with the surrogate's own uncertainty counted as part
// of the measurement's. A repeated measurement has the same error of the surrogate and the same
// discrepancy as the first one. Deterministic.
std::vector<MeasurementValue> rank_measurements(const Study& study, const ResponseModels& models,
                                                const Posterior& posterior);

}  // namespace firn
