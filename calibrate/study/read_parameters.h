// [[parameters]], [[constraints]] and [[compare]] of a study file.
#pragma once

#include <string>

#include "calibrate/study/study_file.h"

namespace firn {

class TomlTable;

// A number with the text of its unit: bare, or "2.4 in".
struct StatedQuantity {
  double value = 0;
  std::string unit;
};
// The value of a key that may or may not have a dimension.
StatedQuantity read_stated_quantity(const TomlTable& table, const std::string& key);

// All throw InputError with file, line and key.
void read_parameters(const TomlTable& root, Study& study);
void read_constraints(const TomlTable& root, Study& study);  // after the parameters
void read_compare(const TomlTable& root, Study& study);      // after the parameters

}  // namespace firn
