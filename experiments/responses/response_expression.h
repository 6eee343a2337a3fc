// What a criterion compares: a number, a response of a run, or something made of the values of one.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/results/response.h"

namespace firn {

// "2.5" | "NAME" | "NAME[K]", the K-th value counted from 1 | "max NAME", "min", "mean", "sum",
// "median" of all values that are defined.
struct ResponseExpression {
  enum class Part { number, single, element, max, min, mean, sum, median };
  std::string text;
  Part part = Part::number;
  std::string response;
  std::size_t element = 0;  // from 0
  double number = 0;
};

// Throws InputError (one sentence).
ResponseExpression parse_response_expression(const std::string& text);

// NaN: undefined in this run (there are no such values). Throws InputError (one sentence) for a
// response that the run does not have, and for one of several values where one is expected.
double evaluate(const ResponseExpression& operand, const std::vector<Response>& responses);
// Its unit; empty for a number, or when the run does not have the response.
std::string unit_of(const ResponseExpression& operand, const std::vector<Response>& responses);

}  // namespace firn
