// How a study ends.
#pragma once

namespace firn {

enum class StudyVerdict {
  calibrated,      // every parameter is determined by the data
  undetermined,    // the target is met by a family of parameter sets; the answer is the family
  unconfirmed,     // the fit met the target, fresh runs at its answer did not
  out_of_reach,    // simulated where they come nearest, the targets are not met together
  prior_conflict,  // the targets can be met, but not by parameters that the priors allow
  searched,        // the best that a direct search met; nothing is known of what else would do
  too_few_runs,    // so many runs failed or arched that nothing could be fitted
  interrupted      // stopped by the user; the same command resumes
};
const char* to_string(StudyVerdict verdict);

}  // namespace firn
