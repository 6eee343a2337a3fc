#include "reports/documents/study_estimate.h"

#include <gtest/gtest.h>

#include "calibrate/output/study_verdict.h"

namespace firn {
namespace {

using Json = nlohmann::ordered_json;

std::vector<page::Property> estimate_of(const Json& results) {
  return study_estimate(document_from_json<StudyDocument>(results, "results.json"));
}

// The first line of every outcome: the values are recommended plainly only where the study stands
// behind them.
TEST(StudyAnswer, RecommendsWhatTheVerdictAllows) {
  Json results = {
      {"study", "heap"},
      {"estimate", {{"name", "estimate"}, {"parameters", {{"mu", 0.155}}}}},
      {"parameters", {{{"name", "mu"}, {"unit", "1"}, {"interval_95", {0.203, 0.298}}}}},
      {"verdict", ""}};
  const struct {
    StudyVerdict verdict;
    std::string line;
  } cases[] = {
      {StudyVerdict::calibrated, "mu = 0.155 (95 %: 0.203 to 0.298)"},
      {StudyVerdict::not_identifiable,
       "mu = 0.155 (95 %: 0.203 to 0.298); other values meet the targets as well"},
      {StudyVerdict::unconfirmed,
       "nothing, since fresh runs did not confirm the fitted values; fitted: mu = 0.155"},
      {StudyVerdict::infeasible,
       "nothing, since no values within the ranges meet all targets; nearest: mu = 0.155"},
      {StudyVerdict::prior_conflict,
       "nothing, since the priors conflict with the targets; nearest to both: mu = 0.155"},
  };
  for (const auto& c : cases) {
    results["verdict"] = to_string(c.verdict);
    EXPECT_EQ(estimate_of(results).front().value, c.line);
  }
  // A direct search has no model, and so neither intervals nor combinations.
  results["verdict"] = to_string(StudyVerdict::direct_search_only);
  results["parameters"][0].erase("interval_95");
  EXPECT_EQ(estimate_of(results)[0].value,
            "mu = 0.155; the best of a direct search, of unknown uncertainty");
  EXPECT_EQ(estimate_of(results)[1].value, "not examined");
  // Without runs there is no estimate.
  results["verdict"] = to_string(StudyVerdict::too_few_runs);
  results.erase("estimate");
  EXPECT_TRUE(estimate_of(results).empty());
}

TEST(StudyAnswer, SaysWhatCombinationsRestOn) {
  Json results = {{"study", "heap"},
                  {"estimate", {{"name", "estimate"}, {"parameters", {{"mu", 0.155}}}}},
                  {"parameters", Json::array()},
                  {"verdict", ""},
                  {"combinations",
                   {{{"identifiable", true},
                     {"terms", {{{"parameter", "mu"}, {"coefficient", 1.0}}}},
                     {"value", 0.155},
                     {"uncertainty", 0.05}}}}};
  const std::string known = "1.00 mu = 0.155 ± 0.050. Not determined: nothing that was varied";
  for (const auto& [verdict, line] :
       {std::pair(StudyVerdict::calibrated, known),
        std::pair(StudyVerdict::not_identifiable, known),
        std::pair(StudyVerdict::unconfirmed, "by a fit that is not confirmed: " + known),
        std::pair(StudyVerdict::infeasible, "by a fit that misses the targets: " + known),
        std::pair(StudyVerdict::prior_conflict, "by priors and targets that conflict: " + known)}) {
    results["verdict"] = to_string(verdict);
    EXPECT_EQ(estimate_of(results)[1].value, line);
  }
}

TEST(StudyAnswer, AdvisesMoreRunsWhereTheyLimitWhatIsDetermined) {
  Json results = {
      {"study", "heap"},
      {"estimate", {{"name", "estimate"}, {"parameters", {{"mu", 0.155}}}}},
      {"verdict", "calibrated"},
      {"parameters", Json::array()},
      {"combinations",
       {{{"identifiable", true},
         {"terms", {{{"parameter", "mu"}, {"coefficient", 1.0}}}},
         {"value", 0.155},
         {"uncertainty", 0.05},
         {"split", {{"measurement", 0.01}, {"seed_noise", 0.03}, {"surrogate", 0.0}}}}}},
      {"measure_next",
       {{{"response", "angle"},
         {"repeats_a_target", true},
         {"uncertainty", 0.1},
         {"information_bits", 0.1},
         {"remaining_extent", 0.97}}}}};
  const auto next = [&] { return estimate_of(results).back().value; };
  EXPECT_EQ(
      next(),
      "first more runs (a larger budget): they make 90 % of the variance of what is determined; "
      "then angle, once more: 0.1 bits; the least known direction shrinks to 97 % of its length");
  Json& split = results["combinations"][0]["split"];
  split["discrepancy"] = 0.04;  // 0.0009 of 0.0026
  EXPECT_EQ(next(),
            "angle, once more: 0.1 bits; the least known direction shrinks to 97 % of its length");
  split.erase("discrepancy");
  split["seed_noise"] = 0.005;
  EXPECT_EQ(next(),
            "angle, once more: 0.1 bits; the least known direction shrinks to 97 % of its length");
}

TEST(StudyAnswer, ComparesTheResponsesOfTheTargets) {
  const auto simulated = [](double value) {
    return Json{{"value", value}, {"standard_error", 0.25}, {"unit", "deg"}};
  };
  const Json results = {
      {"study", "heap"},
      {"verdict", "calibrated"},
      {"parameters", Json::array()},
      {"estimate", {{"name", "estimate"}, {"parameters", {{"mu", 0.155}}}}},
      {"targets", {{{"response", "heap.angle"}, {"value", 10}, {"uncertainty", 1}}}},
      {"compare",
       {{{"name", "paper"},
         {"parameters", {{"mu", 0.3}}},
         {"simulated", {{"heap.angle", simulated(18)}, {"heap.height", simulated(3)}}}}}}};
  EXPECT_EQ(estimate_of(results)[2].value, "paper: heap.angle 18.00 ± 0.25 deg");
}

}  // namespace
}  // namespace firn
