// Loads on particles against their breaking force.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/responses/response_expression.h"
#include "validation/comparison/comparison_kinds.h"

namespace firn::comparison {
namespace {

std::vector<std::vector<double>> loads_by_run(const RunGroup& base, const std::string& response) {
  std::vector<std::vector<double>> runs;
  for (const JobResult* run : base.finished()) {
    const auto found = std::ranges::find(run->responses, response, &Response::name);
    if (found == run->responses.end())
      throw InputError(
          fmt::format("\"{}\" is not a response of the case; expected loads, one value a "
                      "particle, such as \"compressive_loads\"",
                      response));
    runs.push_back(defined(found->value));
  }
  return runs;
}

}  // namespace

void compare_breakage(const SuiteComparison& what, const ComparisonRuns& e, Comparison& c) {
  if (e.base->finished().empty()) {
    c.headline = "no run finished";
    c.recommended_action = "runs that finish";
    return;
  }
  c.strength = fit_weibull(what.measurement);
  c.breaking_force = what.measurement;
  for (std::size_t i = 0; i < what.responses.size(); ++i) {
    const std::string& response = what.responses[i];
    const std::string place = what.response_place(i);
    require_unit("max " + response, *e.base, what.measurement);
    const auto runs = with_place(place, [&] { return loads_by_run(*e.base, response); });
    BreakageResult d;
    d.response = response;
    for (const auto& run : runs) d.loads.insert(d.loads.end(), run.begin(), run.end());
    if (d.loads.empty())
      throw InputError(fmt::format("{}{}\"{}\" has no values in any run", place,
                                   place.empty() ? "" : ": ", response));
    std::ranges::sort(d.loads);
    d.particles = static_cast<int>(d.loads.size());
    d.largest = d.loads.back();
    d.median = d.loads[(d.loads.size() - 1) / 2];
    d.free = breakage_distribution_free(runs, what.measurement);
    d.weibull = breakage_weibull(runs, *c.strength);
    c.breakage.push_back(d);
  }
  // The first of the responses is the one to be judged by.
  const BreakageResult& d = c.breakage.front();
  const bool some = d.free.any.low > improbable, none = d.free.any.high < improbable;
  c.headline = fmt::format(
      "largest of {} loads {:.3g} N, weakest of {} tests {:.4g} N; at least one particle of a run "
      "is damaged with a probability of {:.2g} to {:.2g} whatever the distribution of strengths, "
      "{:.2g} ({:.2g} to {:.2g}) if it is Weibull's",
      d.particles, d.largest, what.measurement.repeats, what.measurement.minimum, d.free.any.low,
      d.free.any.high, d.weibull.any_best, d.weibull.any.low, d.weibull.any.high);
  if (some || none)
    c.verdict = some == what.expects_breakage ? ValidationVerdict::consistent
                                              : ValidationVerdict::inconsistent;
  else
    c.recommended_action = fmt::format(
        "breaking tests in the direction in which the auger presses: {} leave open "
        "whether {:.0f} % of all cubes break below the smallest force seen",
        what.measurement.repeats, 100 * distribution_band_width(what.measurement.repeats));
}

}  // namespace firn::comparison
