#include "reports/documents/study_answer.h"

#include <gtest/gtest.h>

namespace firn {
namespace {

TEST(StudyAnswer, RecommendsNothingWhereTheTargetsAreOutOfReach) {
  Json results = {
      {"estimate", {{"parameters", {{"mu", 0.155}}}}},
      {"parameters", {{{"name", "mu"}, {"unit", "1"}, {"interval_95", {0.203, 0.298}}}}},
      {"verdict", "not identifiable"}};
  const auto recommended = [&] { return study_answer(results).front().value; };
  EXPECT_EQ(recommended(), "mu = 0.155 (95 %: 0.203 to 0.298)");
  results["verdict"] = "infeasible";
  EXPECT_EQ(recommended(),
            "nothing, since no values within the ranges meet all targets; nearest: mu = 0.155");
}

}  // namespace
}  // namespace firn
