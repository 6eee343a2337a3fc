// Finds whether an input was calibrated with the data of a measurement. Data are identified by
// content, not by name. Pure functions.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/material_records/material_record.h"
#include "experiments/measurements/measurement.h"

namespace firn {

// Identity of a datum. Response names are without the name of a study's experiment.
struct DataIdentity {
  std::string experiment;  // as stated; empty: not stated
  std::vector<std::string> responses;
  bool has_value = false;  // with
  double value = 0, uncertainty = 0;
  std::string unit;
};
DataIdentity identity_of(const Measurement& measurement, const std::vector<std::string>& operands);
DataIdentity identity_of(const UsedMeasurement& used);

// Why two data are regarded as the same, as a clause; nothing when they are different. Data are the
// same with: a value, uncertainty and unit that are equal, whatever the response is called; one
// response of one stated experiment; one response with values closer than a twentieth of their
// uncertainty or half a percent, whatever the experiments are called; and one response where not
// both state their experiment, unless the values contradict each other (two standard
// uncertainties).
std::optional<std::string> same_data(const DataIdentity& a, const DataIdentity& b);

// Whether the values that a case has for a record's keys are those of the record: all within 5 % of
// its values, of a reference set, or of a sample of its ensemble. `values`: in order of its
// parameters, in their units; NaN: the case has none.
bool has_values_of(const MaterialRecord& record, const std::vector<double>& values);

// Of each parameter of a record, from the complete text of a case.
std::vector<double> values_in_case(const MaterialRecord& record, const std::string& resolved);

}  // namespace firn
