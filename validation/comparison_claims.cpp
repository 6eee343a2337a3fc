// What was said in words, and the numbers behind the words.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "experiments/batch/operand.h"
#include "experiments/small_samples.h"
#include "validation/comparison_parts.h"

namespace firn::comparison {
namespace {

constexpr double claim_confidence = 0.9;  // 95 % on the side that the verdict looks at

ValidationVerdict judge_claim(const ClaimResult& r) {
  if (r.runs == 0) return ValidationVerdict::not_enough_data;
  if (r.claim.once_in > 0) {
    // Seen in one trial at least of so many.
    const double trials = r.claim.once_in;
    const auto seen = [&](double p) { return 1 - std::pow(1 - p, trials); };
    if (seen(r.probability.high) < improbable) return ValidationVerdict::inconsistent;
    if (seen(r.probability.low) > improbable) return ValidationVerdict::consistent;
    return ValidationVerdict::not_enough_data;
  }
  if (r.probability.high < rule) return ValidationVerdict::inconsistent;
  if (r.probability.low > rule) return ValidationVerdict::consistent;
  return ValidationVerdict::not_enough_data;
}

// The fewest further runs that could settle the claim if they all come out as most have.
int runs_to_settle(ClaimResult r) {
  if (r.runs == 0) return 1;
  const bool mostly = 2 * r.holds >= r.runs;
  for (int more = 1; more <= 1000; ++more) {
    r.holds += mostly;
    r.probability = binomial_interval(r.holds, ++r.runs, claim_confidence);
    if (judge_claim(r) != ValidationVerdict::not_enough_data) return more;
  }
  return 1000;
}

ClaimResult evaluate_claim(const Claim& claim, const RunGroup& base) {
  ClaimResult r;
  r.claim = claim;
  const Operand larger = parse_operand(claim.larger), than = parse_operand(claim.than);
  for (const JobResult* run : base.finished()) {
    r.larger.push_back(evaluate(larger, run->responses));
    r.than.push_back(evaluate(than, run->responses));
    r.unit = unit_of(larger, run->responses);
    const bool known = !std::isnan(r.larger.back()) && !std::isnan(r.than.back());
    r.runs += known;
    r.holds += known && r.larger.back() > claim.times * r.than.back();
  }
  r.probability = binomial_interval(r.holds, r.runs, claim_confidence);
  r.verdict = judge_claim(r);
  return r;
}

// What runs say of the response that the data are of; throws InputError unless it is there.
const Response& response_of(const JobResult& run, const MeasuredData& data,
                            const std::string& unit) {
  const auto found = std::ranges::find(run.responses, data.response, &Response::name);
  if (found == run.responses.end() || found->unit != unit)
    throw InputError(fmt::format(
        "{}: response: \"{}\" in \"{}\" is none of the case's; expected one, in its unit",
        data.file, data.response, unit));
  if (data.present && data.kind == MeasuredData::Kind::classes &&
      found->value.size() != data.counts.size())
    throw InputError(fmt::format("{}: has {} classes; expected {}, as the response \"{}\" has",
                                 data.file, data.counts.size(), found->value.size(),
                                 data.response));
  return *found;
}

// Counts of all runs together, and how the share of each class scatters over the runs.
void add_counts(const std::vector<const Response*>& runs, DistributionResult& d) {
  if (runs.empty()) return;
  std::size_t classes = 0;
  for (const Response* r : runs) classes = std::max(classes, r->value.size());
  d.simulated.assign(classes, 0);
  std::vector<std::vector<double>> shares(classes);
  for (const Response* r : runs) {
    double sum = 0;
    for (const double n : r->value) sum += n;
    for (std::size_t k = 0; k < classes; ++k) {
      const double n = k < r->value.size() ? r->value[k] : 0;
      d.simulated[k] += n;
      if (sum > 0) shares[k].push_back(n / sum);
    }
  }
  for (const auto& share : shares) d.deviation.push_back(facts_of(share).deviation);
  if (d.classes.empty())
    for (std::size_t k = 1; k <= classes; ++k) d.classes.push_back(std::to_string(k));
}

void add_values(const std::vector<const Response*>& runs, DistributionResult& d) {
  for (const Response* r : runs)
    for (const double v : r->value)
      if (std::isfinite(v)) d.simulated.push_back(v);
  std::ranges::sort(d.simulated);
}

// The companion of residence times: how long what has not passed has been inside.
std::vector<double> still_inside(const RunGroup& base, const std::string& response) {
  constexpr std::string_view times = "_residence_times", waiting = "_waiting_times";
  std::vector<double> all;
  if (!response.ends_with(times)) return all;
  const std::string name =
      response.substr(0, response.size() - times.size()) + std::string(waiting);
  for (const JobResult* run : base.finished())
    if (const auto found = std::ranges::find(run->responses, name, &Response::name);
        found != run->responses.end())
      all.insert(all.end(), found->value.begin(), found->value.end());
  return all;
}

void judge_open_times(DistributionResult& d) {
  const CensoredTimes a{d.simulated, d.simulated_at_least}, b{d.measured, d.measured_at_least};
  d.distance = passed_distance(kaplan_meier(a), kaplan_meier(b));
  d.p_value = passed_p_value(a, b, 999);
  d.area = d.area_p_value = std::numeric_limits<double>::quiet_NaN();
}

void judge_distribution(DistributionResult& d) {
  const bool any = std::ranges::any_of(d.simulated, [&](double v) { return !d.by_class || v > 0; });
  if (!any) return;
  if (d.by_class) {
    d.distance = share_distance(d.simulated, d.measured);
    d.p_value = share_p_value(d.simulated, d.measured);
  } else if (!d.simulated_at_least.empty() || !d.measured_at_least.empty()) {
    judge_open_times(d);
  } else {
    d.distance = smirnov_distance(d.simulated, d.measured);
    d.p_value = smirnov_p_value(d.simulated, d.measured);
    d.area = wasserstein_distance(d.simulated, d.measured);
    d.area_p_value = permutation_p_value(d.simulated, d.measured, wasserstein_distance, 999);
  }
  d.verdict =
      d.p_value < improbable ? ValidationVerdict::inconsistent : ValidationVerdict::consistent;
}

DistributionResult compare_distribution(const MeasuredData& data, const RunGroup& base) {
  DistributionResult d;
  d.response = data.response;
  d.by_class = data.kind == MeasuredData::Kind::classes;
  d.unit = d.by_class ? "1" : data.unit;
  d.classes = data.classes;
  d.measured = d.by_class ? data.counts : data.values;
  if (!d.by_class) std::ranges::sort(d.measured);
  std::vector<const Response*> runs;
  for (const JobResult* run : base.finished()) runs.push_back(&response_of(*run, data, d.unit));
  if (d.by_class)
    add_counts(runs, d);
  else
    add_values(runs, d);
  d.measured_at_least = data.at_least;
  d.simulated_at_least = still_inside(base, data.response);
  if (data.present)
    judge_distribution(d);
  else
    d.verdict = ValidationVerdict::information;
  return d;
}

std::string distribution_words(const DistributionResult& d) {
  if (d.verdict == ValidationVerdict::not_enough_data) return "no run gave values";
  const bool open = !d.simulated_at_least.empty() || !d.measured_at_least.empty();
  const std::string what =
      d.by_class ? "share that would have to be exchanged"
      : open     ? "largest distance of the shares that have passed (Kaplan and Meier)"
                 : "largest distance of the cumulative distributions";
  const std::string area =
      d.by_class || open ? "" : fmt::format(" (area {:.3g} {})", d.area, d.unit);
  return fmt::format("{}: {:.2g}{}, which chance alone exceeds in {:.2g} % of all cases", what,
                     d.distance, area, 100 * d.p_value);
}

}  // namespace

void compare_claims(const SuiteComparison& what, const Evidence& e, Comparison& c) {
  int consistent = 0, inconsistent = 0, more = 0;
  for (const Claim& claim : what.measurement.claims) {
    const ClaimResult r = evaluate_claim(claim, *e.base);
    consistent += r.verdict == ValidationVerdict::consistent;
    inconsistent += r.verdict == ValidationVerdict::inconsistent;
    if (r.verdict == ValidationVerdict::not_enough_data) more = std::max(more, runs_to_settle(r));
    c.claims.push_back(r);
  }
  const auto all = static_cast<int>(c.claims.size());
  c.headline = fmt::format(
      "of {} statement{}, {} hold{} in the simulation, {} do{} not, {} stay{} "
      "open",
      all, all == 1 ? "" : "s", consistent, consistent == 1 ? "s" : "", inconsistent,
      inconsistent == 1 ? "es" : "", all - consistent - inconsistent,
      all - consistent - inconsistent == 1 ? "s" : "");
  c.verdict = inconsistent > 0    ? ValidationVerdict::inconsistent
              : consistent == all ? ValidationVerdict::consistent
                                  : ValidationVerdict::not_enough_data;
  const auto& data = what.measurement.data;
  if (data) c.distribution = compare_distribution(*data, *e.base);
  if (data && data->present) {
    c.headline += "; " + distribution_words(*c.distribution);
    if (c.distribution->verdict == ValidationVerdict::inconsistent)
      c.verdict = ValidationVerdict::inconsistent;
  } else if (data) {
    c.caveats.push_back(
        fmt::format("the experiment's numbers are not here; as {} they would be "
                    "compared",
                    data->file));
  }
  if (more > 0)
    c.would_decide =
        fmt::format("at least {} more run{} with other seeds", more, more == 1 ? "" : "s");
}

}  // namespace firn::comparison
