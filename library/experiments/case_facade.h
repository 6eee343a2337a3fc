// What experiments::Case holds. Not installed.
#pragma once

#include "experiments/case/case.h"
#include "firn/experiments/case.h"

namespace firn::experiments {

struct Case::Impl {
  std::string file;             // read again for other overrides; empty: `text`
  std::string text, directory;  // of a case that is not in a file
  std::vector<Override> overrides;
  MaterialRequest materials;
  firn::Case checked;
};

}  // namespace firn::experiments
