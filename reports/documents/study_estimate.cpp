#include "reports/documents/study_estimate.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <vector>

#include "experiments/text/number_text.h"

namespace firn {
namespace {

std::string joined(const std::vector<std::string>& parts, const char* none) {
  return parts.empty() ? none : fmt::format("{}", fmt::join(parts, "; "));
}

// NaN for what is no number. Any size: a study may have responses up to 1e308.
double value_of(const Json& value) {
  return value.is_number() ? value.get<double>() : std::nan("");
}

std::string unit_suffix_of(const Json& value) { return unit_suffix(value.value("unit", "1")); }

// "law = linear (probability 0.97)"
std::string chosen(const Json& choice) {
  const std::string best = choice.at("best");
  for (const Json& c : choice.at("choices"))
    if (c.at("choice") == best)
      return fmt::format("{} = {} (probability {})", choice.at("parameter").get<std::string>(),
                         best, number_text(value_of(c.at("probability")), 2));
  return fmt::format("{} = {}", choice.at("parameter").get<std::string>(), best);
}

// "ice_ice = 0.24 (95 %: 0.17 to 0.3)". Where no values meet all targets, the interval holds the
// truth of a model that is refuted: the nearest values alone.
std::string recommended(const Json& j) {
  const bool out_of_reach = j.value("verdict", "") == "infeasible";
  const Json& values = j.at("estimate").at("parameters");
  std::vector<std::string> parts;
  if (j.contains("choice")) parts.push_back(chosen(j.at("choice")));
  for (const Json& p : j.value("parameters", Json::array())) {
    const std::string name = p.at("name");
    if (!values.contains(name)) continue;
    const Json interval = p.value("interval_95", Json::array());
    std::string text =
        fmt::format("{} = {}{}", name, number_text(value_of(values.at(name))), unit_suffix_of(p));
    if (interval.size() == 2 && !out_of_reach)
      text += fmt::format(" (95 %: {} to {})", number_text(value_of(interval[0]), 3),
                          number_text(value_of(interval[1]), 3));
    parts.push_back(text);
  }
  const std::string values_text = joined(parts, "no values");
  return out_of_reach ? "nothing, since no values within the ranges meet all targets; nearest: " +
                            values_text
                      : values_text;
}

std::string determined(const Json& j) {
  std::vector<std::string> known, unknown;
  for (const Json& c : j.value("combinations", Json::array())) {
    if (c.value("identifiable", false))
      known.push_back(
          fmt::format("{} = {}", combination_text(c),
                      measured_text(value_of(c.at("value")), value_of(c.at("uncertainty")))));
    else
      unknown.push_back(combination_text(c));
  }
  return fmt::format("{}. Not determined: {}", joined(known, "nothing"),
                     joined(unknown, "nothing that was varied"));
}

std::string simulated(const Json& set) {
  std::vector<std::string> parts;
  const Json responses = set.value("simulated", Json::object());
  for (const auto& [response, value] : responses.items())
    parts.push_back(fmt::format(
        "{} {}{}", response,
        measured_text(value_of(value.at("value")), value_of(value.value("standard_error", Json()))),
        unit_suffix_of(value)));
  return joined(parts, "no finished run");
}

std::string compared(const Json& j) {
  std::vector<std::string> parts;
  for (const Json& set : j.value("compare", Json::array()))
    parts.push_back(
        fmt::format("{}: {}", set.value("name", std::string("unnamed")), simulated(set)));
  return joined(parts, "the study has no [[compare]] values");
}

// Share of the variance of the combination known best that the runs make: their scatter and what
// lies between them. The measurements and discrepancies make the rest. 0: nothing is determined.
double share_of_runs(const Json& j) {
  for (const Json& c : j.value("combinations", Json::array())) {
    if (!c.value("identifiable", false) || !c.contains("split")) continue;
    const auto part = [&](const char* name) {
      const double sd = value_of(c.at("split").value(name, Json()));
      return sd * sd;
    };
    const double runs = part("seed_noise") + part("surrogate");
    double all = runs + part("measurement");
    if (c.at("split").contains("discrepancy")) all += part("discrepancy");
    return all > 0 ? runs / all : 0;
  }
  return 0;
}

std::string next(const Json& j) {
  const double runs = share_of_runs(j);
  const std::string first =
      runs > 0.5 ? fmt::format(
                       "first more runs (a larger budget): they make {:.0f} % of the variance "
                       "of what is determined; then ",
                       100 * runs)
                 : "";
  const Json advice = j.value("measure_next", Json::array());
  if (advice.empty()) return first + "nothing is known to help";
  const Json& best = advice.front();
  std::string text = first + best.value("response", std::string("?"));
  if (best.value("repeats_a_target", false)) text += ", once more";
  text += fmt::format(": {} bits", number_text(value_of(best.at("information_bits")), 2));
  if (const double left = value_of(best.value("remaining_extent", Json())); !std::isnan(left))
    text +=
        fmt::format("; the least known direction shrinks to {:.0f} % of its length", 100 * left);
  return text;
}

}  // namespace

std::string combination_text(const Json& c) {
  std::string text;
  for (const Json& term : c.at("terms")) {
    const double factor = value_of(term.at("coefficient"));
    const std::string name = term.at("parameter");
    const std::string what =
        term.value("of", "") == "logarithm" ? fmt::format("ln({})", name) : name;
    text += text.empty()
                ? fmt::format("{:.2f} {}", factor, what)
                : fmt::format(" {} {:.2f} {}", factor < 0 ? "-" : "+", std::abs(factor), what);
  }
  return text;
}

std::vector<page::Fact> study_estimate(const Json& results) {
  if (!results.contains("estimate") || !results.at("estimate").is_object()) return {};
  return {{"Recommended", recommended(results)},
          {"Determined", determined(results)},
          {"Compared", compared(results)},
          {"Measure next", next(results)}};
}

}  // namespace firn
