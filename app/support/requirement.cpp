#include "app/support/requirement.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>

#include "experiments/system/input_file.h"
#include "experiments/text/response_aliases.h"
#include "experiments/text/toml_aliases.h"
#include "firn/math.h"

namespace firn {
namespace {

bool keeps(double value, const Requirement& r) {
  switch (r.relation) {
    case Requirement::Relation::at_most:
      return value <= r.bound;
    case Requirement::Relation::at_least:
      return value >= r.bound;
    case Requirement::Relation::below:
      return value < r.bound;
    case Requirement::Relation::above:
      return value > r.bound;
  }
  return false;
}

const Response& find_response(const std::vector<Response>& responses, const std::string& name) {
  const auto found = std::find_if(responses.begin(), responses.end(),
                                  [&](const Response& r) { return r.name == name; });
  if (found != responses.end()) return *found;
  std::string names;
  for (const Response& r : responses) names += (names.empty() ? "" : ", ") + r.name;
  throw InputError(
      fmt::format("--require: {}: no such response; expected {}", name,
                  names.empty() ? "nothing, the case has no responses" : "one of " + names));
}

}  // namespace

Requirement parse_requirement(const std::string& text) {
  const auto fail = [&] {
    return InputError(fmt::format(
        "--require: {}: not a bound; expected RESPONSE<=VALUE, >=, < or >, VALUE in the "
        "response's own unit",
        text));
  };
  const auto sign = text.find_first_of("<>");
  if (sign == std::string::npos) throw fail();
  const bool or_equal = sign + 1 < text.size() && text[sign + 1] == '=';
  Requirement r;
  r.text = text;
  const std::string name = trimmed(text.substr(0, sign));
  r.response = current_response_name(name);
  if (r.response != name) warn_of_old_name("--require", {text, 0, name, r.response, false});
  if (text[sign] == '<') {
    r.relation = or_equal ? Requirement::Relation::at_most : Requirement::Relation::below;
  } else {
    r.relation = or_equal ? Requirement::Relation::at_least : Requirement::Relation::above;
  }
  const std::string value = trimmed(text.substr(sign + (or_equal ? 2 : 1)));
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), r.bound);
  if (error != std::errc() || end != value.data() + value.size() || r.response.empty())
    throw fail();
  return r;
}

std::vector<RequirementResult> check_requirements(const std::vector<Requirement>& requirements,
                                                  const std::vector<Response>& responses) {
  std::vector<RequirementResult> verdicts;
  for (const Requirement& requirement : requirements) {
    const Response& response = find_response(responses, requirement.response);
    const bool met = !response.value.empty() &&
                     std::all_of(response.value.begin(), response.value.end(),
                                 [&](double value) { return keeps(value, requirement); });
    verdicts.push_back({requirement, met});
  }
  return verdicts;
}

bool all_met(const std::vector<RequirementResult>& verdicts) {
  return std::all_of(verdicts.begin(), verdicts.end(),
                     [](const RequirementResult& v) { return v.met; });
}

}  // namespace firn
