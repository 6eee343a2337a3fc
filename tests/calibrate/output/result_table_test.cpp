// What the table of a study says of its estimate, by outcome.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibrate/output/calibration_result.h"
#include "calibrate/study/study_file.h"

namespace firn {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(ResultTable, NamesTheEstimateByTheOutcome) {
  Study study;
  Parameter mu;
  mu.name = "mu";
  mu.max = 1;
  study.parameters = {mu};
  CalibrationResult a;
  a.best.name = "answer";
  a.best.values = {0.155};
  const struct {
    StudyVerdict verdict;
    std::string title;
  } cases[] = {
      {StudyVerdict::calibrated, "Answer, confirmed with seeds never used before"},
      {StudyVerdict::not_identifiable, "Answer, confirmed with seeds never used before"},
      {StudyVerdict::unconfirmed,
       "Fitted to the targets, NOT CONFIRMED by seeds never used before"},
      {StudyVerdict::infeasible, "Nearest to the targets, simulated with seeds never used before"},
      {StudyVerdict::prior_conflict,
       "Nearest to the targets and the priors, simulated with seeds never used before"},
      {StudyVerdict::direct_search_only,
       "Best of the search, simulated with seeds never used before"},
  };
  for (const auto& c : cases) {
    a.verdict = c.verdict;
    const std::string table = render_table(study, a);
    EXPECT_THAT(table, HasSubstr("\n" + c.title + "\n")) << to_string(c.verdict);
    EXPECT_THAT(table, HasSubstr("mu = 0.155")) << to_string(c.verdict);
  }
  a.verdict = StudyVerdict::too_few_runs;
  a.best.values.clear();
  EXPECT_THAT(render_table(study, a), Not(HasSubstr("mu = ")));
}

}  // namespace
}  // namespace firn
