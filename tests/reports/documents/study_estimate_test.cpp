#include "reports/documents/study_estimate.h"

#include <gtest/gtest.h>

namespace firn {
namespace {

using Json = nlohmann::ordered_json;

std::vector<page::Property> estimate_of(const Json& results) {
  return study_estimate(document_from_json<StudyDocument>(results, "results.json"));
}

TEST(StudyAnswer, RecommendsNothingWhereTheTargetsAreOutOfReach) {
  Json results = {
      {"study", "heap"},
      {"estimate", {{"name", "estimate"}, {"parameters", {{"mu", 0.155}}}}},
      {"parameters", {{{"name", "mu"}, {"unit", "1"}, {"interval_95", {0.203, 0.298}}}}},
      {"verdict", "not identifiable"}};
  const auto recommended = [&] { return estimate_of(results).front().value; };
  EXPECT_EQ(recommended(), "mu = 0.155 (95 %: 0.203 to 0.298)");
  results["verdict"] = "infeasible";
  EXPECT_EQ(recommended(),
            "nothing, since no values within the ranges meet all targets; nearest: mu = 0.155");
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
