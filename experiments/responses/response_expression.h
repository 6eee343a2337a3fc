// Expressions of responses in criteria: a number, a response, or a statistic of its values.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/results/response.h"

namespace firn {

// "2.5" | "NAME" | "NAME[K]" (the K-th value, from 1) | "max NAME" | "min NAME" | "mean NAME" |
// "sum NAME" | "median NAME" (over all defined values).
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

// NaN if undefined in this run (no such value). Throws InputError (one sentence) for a response
// that the run does not have, and for a response of several values where one is expected.
double evaluate(const ResponseExpression& operand, const std::vector<Response>& responses);
// Unit of the response; empty for a number and for a response that the run does not have.
std::string unit_of(const ResponseExpression& operand, const std::vector<Response>& responses);

}  // namespace firn
