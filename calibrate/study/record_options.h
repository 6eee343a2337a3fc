// Data of a material record that the user states in addition to the study.
#pragma once

#include <string>
#include <vector>

#include "experiments/material_records/material_record.h"

namespace firn {

struct RecordOptions {
  std::string name;  // empty: no record is made
  std::string author, note;
  std::vector<ScopeLimit> scope;  // in addition to what follows from the case
};

}  // namespace firn
