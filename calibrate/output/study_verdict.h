// How a study ends.
#pragma once

namespace firn {

enum class StudyVerdict {
  calibrated,          // every parameter is identifiable
  not_identifiable,    // the targets are met along a ridge of parameter sets
  unconfirmed,         // the fit met the targets, fresh runs at the estimate did not
  infeasible,          // runs at the nearest parameters do not meet all targets together
  prior_conflict,      // the targets can be met, but not by parameters that the priors allow
  direct_search_only,  // the best set of a direct search, without a model of the responses
  too_few_runs,        // so many runs failed or arched that nothing could be fitted
  interrupted          // stopped by the user; the same command resumes
};
const char* to_string(StudyVerdict verdict);

}  // namespace firn
