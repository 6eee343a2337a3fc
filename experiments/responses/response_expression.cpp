#include "experiments/responses/response_expression.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>

#include "experiments/analysis/sample_statistics.h"
#include "firn/math.h"

namespace firn {
namespace {

struct Word {
  const char* text;
  ResponseExpression::Part part;
};
constexpr Word words[] = {{"max ", ResponseExpression::Part::max},
                          {"min ", ResponseExpression::Part::min},
                          {"mean ", ResponseExpression::Part::mean},
                          {"sum ", ResponseExpression::Part::sum},
                          {"median ", ResponseExpression::Part::median}};

const Response& find(const ResponseExpression& operand, const std::vector<Response>& responses) {
  const auto found = std::ranges::find(responses, operand.response, &Response::name);
  if (found != responses.end()) return *found;
  std::vector<std::string> names;
  for (const Response& r : responses) names.push_back(r.name);
  throw InputError(fmt::format("\"{}\" is not a response of the case; expected one of {}",
                               operand.response, fmt::join(names, ", ")));
}

}  // namespace

ResponseExpression parse_response_expression(const std::string& text) {
  ResponseExpression o;
  o.text = text;
  const char* end = text.data() + text.size();
  if (const auto [rest, error] = std::from_chars(text.data(), end, o.number);
      error == std::errc() && rest == end && std::isfinite(o.number))
    return o;
  o.part = ResponseExpression::Part::single;
  o.response = text;
  for (const Word& word : words)
    if (text.starts_with(word.text)) {
      o.part = word.part;
      o.response = text.substr(std::string_view(word.text).size());
    }
  const std::size_t bracket = o.response.find('[');
  if (o.part == ResponseExpression::Part::single && bracket != std::string::npos) {
    const char* from = o.response.data() + bracket + 1;
    const char* stop = o.response.data() + o.response.size();
    const auto [rest, error] = std::from_chars(from, stop, o.element);
    if (error != std::errc() || rest + 1 != stop || *rest != ']' || o.element == 0)
      throw InputError(
          fmt::format("\"{}\" has no element counted from 1 in its brackets; expected such as "
                      "\"NAME[2]\"",
                      text));
    --o.element;
    o.part = ResponseExpression::Part::element;
    o.response.resize(bracket);
  }
  if (o.response.empty() || o.response.find_first_of(" []") != std::string::npos)
    throw InputError(fmt::format(
        "\"{}\" is not an operand; expected a number, NAME, NAME[2], or one of max, min, "
        "mean, sum, median and NAME",
        text));
  return o;
}

double evaluate(const ResponseExpression& o, const std::vector<Response>& responses) {
  if (o.part == ResponseExpression::Part::number) return o.number;
  const Response& r = find(o, responses);
  if (o.part == ResponseExpression::Part::single) {
    if (r.value.size() != 1)
      throw InputError(fmt::format("\"{}\" has {} values; expected one, or such as \"max {}\"",
                                   o.response, r.value.size(), o.response));
    return r.value[0];
  }
  if (o.part == ResponseExpression::Part::element)
    return o.element < r.value.size() ? r.value[o.element] : kUndefined;
  std::vector<double> values = r.value;
  std::erase_if(values, [](double v) { return std::isnan(v); });
  const double sum = std::accumulate(values.begin(), values.end(), 0.0);
  if (o.part == ResponseExpression::Part::sum) return sum;
  if (values.empty()) return kUndefined;
  switch (o.part) {
    case ResponseExpression::Part::max:
      return *std::ranges::max_element(values);
    case ResponseExpression::Part::min:
      return *std::ranges::min_element(values);
    case ResponseExpression::Part::median:
      return median(values);
    default:
      return sum / static_cast<double>(values.size());
  }
}

std::string unit_of(const ResponseExpression& o, const std::vector<Response>& responses) {
  const auto found = std::ranges::find(responses, o.response, &Response::name);
  return found == responses.end() ? std::string() : found->unit;
}

}  // namespace firn
