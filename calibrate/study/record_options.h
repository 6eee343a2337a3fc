// What the user says of a material record that a study cannot know.
#pragma once

#include <string>
#include <vector>

#include "experiments/material_records/material_record.h"

namespace firn {

struct RecordOptions {
  std::string name;  // empty: no record is wanted
  std::string author, note;
  std::vector<ScopeLimit> scope;  // in addition to what follows from the case
};

}  // namespace firn
