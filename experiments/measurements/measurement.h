// Measurements by experiment, as files that users may add. Format: docs/measurements.md.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/measurements/measured_data.h"

namespace firn {

// Where the number comes from.
enum class MeasurementStatus { published, digitized, measured, qualitative };
const char* to_string(MeasurementStatus status);

// What is known of the scatter from one repeat to the next.
enum class ScatterKind { standard_deviation, range, values, not_stated };

// A statement in words, and what has to hold of the responses of a run for it to be true there:
// lhs > factor * rhs, all in SI units. Operands: docs/measurements.md.
struct Criterion {
  std::string statement;
  std::string lhs, rhs;
  double factor = 1;
  // Seen once in so many trials, and not as a rule; 0: as a rule.
  int observed_once_in = 0;
  std::string rationale;  // how the words became this relation
};

struct Measurement {
  std::string file;  // it was read from
  std::string name;
  std::string response;  // which response of the simulation it measures; none with claims
  std::string unit;      // of every number here, as the response spells it
  double value = 0;      // mean of the repeats
  int repeats = 1;

  ScatterKind scatter = ScatterKind::not_stated;
  double standard_deviation = 0;      // of one repeat; for a range, estimated from its width
  double minimum = 0, maximum = 0;    // of a range or of given values
  std::vector<double> values;         // the repeats one by one, where given
  std::string assumption;             // not empty: standard_deviation is an assumption, and why
  double systematic_uncertainty = 0;  // one standard deviation, common to all repeats
  std::string systematic_rationale;

  MeasurementStatus status = MeasurementStatus::measured;
  bool recorded = false;  // a qualitative one by its data: a trace or other recorded numbers
  // What was done to get it: measurements of one experiment say the same here. Empty: not stated.
  std::string experiment;
  bool simulated = false;  // a number of another simulation, not of an experiment
  std::string source, apparatus, notes;
  std::string statement;             // of a qualitative one, which has no number
  std::vector<Criterion> criteria;   // the same as relations, where they can be
  std::optional<MeasuredData> data;  // that say more than the words

  // One standard deviation of the mean: sqrt(sd^2 / repeats + reading^2).
  double standard_uncertainty() const;
  // The same, wider when few repeats determine the scatter: the mean then follows Student's
  // distribution (GUM supplement 1, 6.4.9).
  double widened_uncertainty() const;
  // "10 +- 0.96 deg (n = 7; standard deviation 2 deg, assumed: ...; reading 0.6 deg: ...)"
  std::string sentence() const;
};

// The status as the file states it: "recorded" as well.
const char* status_text(const Measurement& measurement);

// A number with the unit it is written in: "10 deg"; a bare number has the unit "1".
struct UnitValue {
  double value = 0;
  std::string unit;
};
// Throws InputError (one sentence) for anything else.
UnitValue parse_unit_value(const std::string& text);

// Throws InputError with one line `FILE:LINE: KEY: what is wrong; what is expected`.
Measurement read_measurement(const std::string& file);
Measurement read_measurement_text(const std::string& text, const std::string& source);

// Replaces earlier names of responses by current ones, with a warning. For measurements that are
// compared with a case; other simulators have responses with names of the user.
void use_current_responses(Measurement& measurement);

// Mean width of the range of n values drawn from a normal distribution, in standard deviations (d2
// of control charts; 2.704 for n = 7). n >= 2.
double expected_range(int n);

}  // namespace firn
