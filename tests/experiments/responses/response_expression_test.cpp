#include "experiments/responses/response_expression.h"

#include <gtest/gtest.h>

#include <cmath>

namespace firn {
namespace {

TEST(ResponseExpression, ReadsNumbersNamesElementsAndSummaries) {
  const std::vector<Response> r = {{"counts", {3, NAN, 5, 4}, {}, "1", "", 1},
                                   {"time", {2}, {}, "s", "", 1}};
  const auto value = [&](const char* text) { return evaluate(parse_response_expression(text), r); };
  EXPECT_EQ(value("-2.5"), -2.5);
  EXPECT_EQ(value("time"), 2);
  EXPECT_EQ(value("counts[3]"), 5);
  EXPECT_TRUE(std::isnan(value("counts[2]")));
  EXPECT_TRUE(std::isnan(value("counts[9]")));
  EXPECT_EQ(value("max counts"), 5);
  EXPECT_EQ(value("min counts"), 3);
  EXPECT_EQ(value("sum counts"), 12);
  EXPECT_EQ(value("mean counts"), 4);
  EXPECT_EQ(value("median counts"), 4);
  EXPECT_THROW(value("counts"), InputError);
  for (const char* wrong : {"", "a b", "counts[0]", "counts[x]", "counts[2", "largest time"})
    EXPECT_THROW(parse_response_expression(wrong), InputError) << wrong;
}

}  // namespace
}  // namespace firn
