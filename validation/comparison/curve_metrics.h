// Comparison of curves of simulation and experiment: force over displacement, acceleration over
// time. Pure functions.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/measurements/measured_data.h"

namespace firn {

using SampledCurve = MeasuredData::Repeat;

struct CurveComparison {
  std::string x_name, x_unit, y_name, y_unit;
  int runs = 0, repeats = 0;
  std::vector<double> x;  // evenly spaced, over the common range of all curves
  // Means at x, and one standard deviation of each mean: NaN for a single curve.
  std::vector<double> measured, measured_error, simulated, simulated_error;
  double shift = 0;  // in x_unit, of the simulation against the experiment, mean over the runs
  double range = 0;  // of the measured mean, to which shares refer
  // Root mean square over x of the difference, its standard uncertainty, and its expanded
  // uncertainty (95 %), as shares of the range; the largest difference and its x.
  double difference = 0, uncertainty = 0, expanded = 0, largest = 0, at = 0;
};

// At `x` on straight lines between the samples, which are in order of x.
double curve_at(const SampledCurve& curve, double x);
// In order of x; the first of equal ones stays.
SampledCurve in_order(SampledCurve curve);
// Shifted so that x = 0 where y first reaches `share` of its largest magnitude.
SampledCurve from_onset(SampledCurve curve, double share = 0.05);
// The shift of `curve` along x with the least-squares distance to `other` (over the common range,
// at least half of the shorter one).
double best_shift(const SampledCurve& curve, const SampledCurve& other);

// Nothing where they do not overlap. Without measured curves the simulated ones alone: x, their
// mean and its error.
std::optional<CurveComparison> compare_curves(std::vector<SampledCurve> simulated,
                                              std::vector<SampledCurve> measured,
                                              MeasuredData::Alignment align);

}  // namespace firn
