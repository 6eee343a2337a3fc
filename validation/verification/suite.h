// Runs verification cases in parallel.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "validation/verification/fixtures/check.h"

namespace firn::verification {

struct CaseResult {
  std::vector<Check> checks;
  std::string error;   // the case ended with this exception; empty: it ran
  double seconds = 0;  // wall time
  bool ran = false;
};

// True when the case ran without an error and all checks hold.
bool passed(const CaseResult& result);
// Largest tolerance fraction of the checks, 0 without checks.
double max_tolerance_fraction(const CaseResult& result);

// All cases of the suite, in the order of the page.
std::vector<VerificationCase> all_cases();

// The cases chosen by names of groups or cases ("impact", "bulk.dice"), in the suite's order. No
// names: all, those of the full tier only when `full`. Throws InputError for an unknown name.
std::vector<VerificationCase> select(const std::vector<std::string>& names, bool full);

// Results in the order of the cases. `jobs` at a time; `done` is called, one call at a time, when a
// case has ended, with all results so far.
std::vector<CaseResult> run_cases(
    const std::vector<VerificationCase>& cases, int jobs,
    const std::function<void(std::size_t, const std::vector<CaseResult>&)>& done);

}  // namespace firn::verification
