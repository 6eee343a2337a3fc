#include "calibrate/output/study_verdict.h"

namespace firn {

const char* to_string(StudyVerdict verdict) {
  switch (verdict) {
    case StudyVerdict::calibrated:
      return "calibrated";
    case StudyVerdict::not_identifiable:
      return "not identifiable";
    case StudyVerdict::unconfirmed:
      return "unconfirmed";
    case StudyVerdict::infeasible:
      return "infeasible";
    case StudyVerdict::prior_conflict:
      return "prior conflict";
    case StudyVerdict::direct_search_only:
      return "direct search only";
    case StudyVerdict::too_few_runs:
      return "too few runs";
    case StudyVerdict::interrupted:
      return "interrupted";
  }
  return "";
}

}  // namespace firn
