// The hard places.
#include "validation/verification/robustness/robustness_cases.h"

#include <iterator>

#include "validation/verification/robustness/cases.h"

namespace firn::verification {

std::vector<VerificationCase> robustness_cases() {
  std::vector<VerificationCase> all;
  for (auto* cases : {tunneling_cases, deep_cases, degenerate_shape_cases}) {
    std::vector<VerificationCase> some = cases();
    all.insert(all.end(), std::make_move_iterator(some.begin()),
               std::make_move_iterator(some.end()));
  }
  return all;
}

}  // namespace firn::verification
