// Measured values of experiments, from measurement files. Format: docs/measurements.md.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/measurements/measured_data.h"

namespace firn {

// Source of the value.
enum class MeasurementStatus { published, digitized, measured, qualitative };
const char* to_string(MeasurementStatus status);

// Form in which the repeatability is stated.
enum class ScatterKind { standard_deviation, range, values, not_stated };

// A qualitative statement and the relation of responses of a run that corresponds to it:
// lhs > factor * rhs, in SI units. Operands: docs/measurements.md.
struct Criterion {
  std::string statement;
  std::string lhs, rhs;
  double factor = 1;
  // Observed once in this number of trials; 0: observed in general.
  int observed_once_in = 0;
  std::string rationale;  // derivation of the relation from the statement
  // Whether the statement holds in a run that fails; nothing: a failed run does not answer it.
  std::optional<bool> if_run_fails = {};
  std::string lhs_place = {}, rhs_place = {};  // "FILE:LINE: KEY" for messages
};

struct Measurement {
  std::string file;  // source file
  std::string name;
  std::string response;  // corresponding response of the simulation; empty with criteria
  std::string unit;      // of all numbers, as of the response
  double value = 0;      // mean of the repeats
  int repeats = 1;

  ScatterKind scatter = ScatterKind::not_stated;
  double standard_deviation = 0;      // of one repeat; estimated from the width of a range
  double minimum = 0, maximum = 0;    // of the range or of `values`
  std::vector<double> values;         // of the repeats, if stated
  std::string assumption;             // reason of an assumed standard_deviation; empty: not assumed
  double systematic_uncertainty = 0;  // one standard deviation, common to all repeats
  std::string systematic_rationale;

  MeasurementStatus status = MeasurementStatus::measured;
  bool recorded = false;  // qualitative, with recorded data such as a trace
  // Name of the experiment, equal for all its measurements. Empty: not stated.
  std::string experiment;
  bool simulated = false;  // result of another simulation, not of an experiment
  std::string source, apparatus, notes;
  std::string statement;             // of a qualitative measurement
  std::vector<Criterion> criteria;   // relations that correspond to the statement
  std::optional<MeasuredData> data;  // detailed data
  // "FILE:LINE: KEY" for messages: of `response`, and of the value or values.
  std::string response_place = {}, value_place = {};

  // Standard uncertainty of the mean (GUM 4 and 5):
  // sqrt(standard_deviation^2 / repeats + systematic_uncertainty^2).
  double standard_uncertainty() const;
  // The same with the larger variance of Student's distribution where few repeats determine the
  // scatter (GUM Supplement 1, 6.4.9).
  double widened_uncertainty() const;
  // "10 +- 0.96 deg (n = 7; standard deviation 2 deg, assumed: ...; reading 0.6 deg: ...)"
  std::string sentence() const;
};

// The status as stated in the file, including "recorded".
const char* status_text(const Measurement& measurement);

// A number and its unit, "10 deg". The unit of a bare number is "1".
struct UnitValue {
  double value = 0;
  std::string unit;
};
// Throws InputError (one sentence) for other text.
UnitValue parse_unit_value(const std::string& text);

// Throws InputError with one line `FILE:LINE: KEY: FAULT; EXPECTATION`.
Measurement read_measurement(const std::string& file);
Measurement read_measurement_text(const std::string& text, const std::string& source);

// Replaces old names of responses by current ones, with a warning. Not for measurements of other
// simulators, whose response names are free.
void use_current_responses(Measurement& measurement);

// Expected range of n values of a normal distribution, in standard deviations: d2 of control
// charts, 2.704 for n = 7. n >= 2.
double expected_range(int n);

}  // namespace firn
