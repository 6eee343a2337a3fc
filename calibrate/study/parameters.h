// Parameters of a study and the unit cube in which designs, surrogates and searches are formulated.
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <string>
#include <vector>

#include "experiments/system/value_place.h"

namespace firn {

// One unknown, bound to one or more case keys that always take the same value.
struct Parameter {
  std::string name;
  std::vector<std::string> keys;  // TOML paths in the case
  double min = 0, max = 0;        // in `unit`
  std::string unit;               // empty: a bare number
  bool logarithmic = false;
  bool integer = false;  // runs get whole numbers; models are continuous between them
  // Gaussian prior in the unit of the parameter, truncated to the range.
  std::optional<double> prior_mean, prior_sd;
  std::vector<ValuePlace> key_places = {};  // [keys] for messages

  // The value, or its logarithm.
  double scaled(double value) const;
  // 0 at min, 1 at max, linear in the value or in its logarithm.
  double to_unit(double value) const;
  double from_unit(double u) const;
  // The nearest value inside the range with four significant digits, or more where these are coarse
  // compared with the range. Runs use this value: it is readable, and rounding errors of a search
  // do not lead to another run.
  double rounded(double u) const;
  // A value with as many digits as tidy() gives.
  std::string text(double value) const;
  double width() const;  // of the range, in the value or in its logarithm
  // Prior mean and standard deviation in the unit cube; without a prior, the middle and an empty
  // value.
  double prior_mean_unit() const;
  std::optional<double> prior_sd_unit() const;
};

// A parameter that takes one of a few values without an order, such as the name of a contact law.
// All of its keys take the same value.
struct ChoiceParameter {
  std::string name;
  std::vector<std::string> keys;                               // TOML paths in the case
  std::vector<std::string> labels;                             // of the choices, for people
  std::vector<std::string> values;                             // of the choices, TOML texts
  std::vector<double> prior;                                   // probabilities; add up to 1
  std::vector<ValuePlace> key_places = {}, value_places = {};  // [keys], [values] for messages
};

Eigen::VectorXd to_unit(const std::vector<Parameter>& parameters,
                        const std::vector<double>& values);
std::vector<double> rounded_values(const std::vector<Parameter>& parameters,
                                   const Eigen::VectorXd& u);

}  // namespace firn
