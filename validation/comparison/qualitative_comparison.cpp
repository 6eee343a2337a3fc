// Compares qualitative observations (criteria) and distributions with the runs.
#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <cmath>
#include <string_view>

#include "experiments/analysis/sample_statistics.h"
#include "experiments/responses/response_expression.h"
#include "experiments/system/value_place.h"
#include "validation/comparison/comparison_kinds.h"
#include "validation/statistics/outlier_test.h"
#include "validation/statistics/two_sample_tests.h"

namespace firn::comparison {
namespace {

std::string unit_of(const MeasuredData& data) {
  return data.kind == MeasuredData::Kind::classes ? "1" : data.unit;
}

}  // namespace

const Response& response_of(const JobResult& run, const MeasuredData& data) {
  const std::string unit = unit_of(data);
  const auto found = std::ranges::find(run.responses, data.response, &Response::name);
  if (found == run.responses.end() || found->unit != unit)
    throw InputError(
        fmt::format("{}: \"{}\" in \"{}\" is none of the case's; expected one, in its unit",
                    place_or_file(data.response_place, data.file), data.response, unit));
  if (data.present && data.kind == MeasuredData::Kind::classes &&
      found->value.size() != data.counts.size())
    throw InputError(fmt::format("{}: has {} classes; expected {}, as the response \"{}\" has",
                                 data.file, data.counts.size(), found->value.size(),
                                 data.response));
  return *found;
}

namespace {

constexpr double criterion_confidence = 0.9;  // 95 % on the side that the verdict depends on
constexpr double half = 0.5;  // critical distance above which there are too few values

ValidationVerdict judge_criterion(const CriterionResult& r) {
  if (r.runs == 0) return ValidationVerdict::inconclusive;
  if (r.criterion.observed_once_in > 0) {
    // Probability of the statement in at least one of `trials` trials.
    const double trials = r.criterion.observed_once_in;
    const auto seen = [&](double p) { return 1 - std::pow(1 - p, trials); };
    if (seen(r.probability.high) < improbable) return ValidationVerdict::inconsistent;
    if (seen(r.probability.low) > improbable) return ValidationVerdict::consistent;
    return ValidationVerdict::inconclusive;
  }
  if (r.probability.high < rule) return ValidationVerdict::inconsistent;
  if (r.probability.low > rule) return ValidationVerdict::consistent;
  return ValidationVerdict::inconclusive;
}

// Bounds of the probability that the statement holds. The statement may hold in all missing runs or
// in none: the cause that removes a run may also decide the statement.
Interval probability_of(const CriterionResult& r) {
  const int all = r.runs + r.missing;
  return {binomial_interval(r.holds, all, criterion_confidence).low,
          binomial_interval(r.holds + r.missing, all, criterion_confidence).high};
}

// Probability of so few runs in which it holds, at the smallest probability that the statement
// allows. Missing runs count as such in which it holds.
double p_against(const CriterionResult& r) {
  if (r.runs == 0) return 1;
  const double least = r.criterion.observed_once_in > 0
                           ? 1 - std::pow(1 - improbable, 1.0 / r.criterion.observed_once_in)
                           : rule;
  return boost::math::cdf(boost::math::binomial_distribution<double>(r.runs + r.missing, least),
                          r.holds + r.missing);
}

// Smallest number of further runs that could decide the criterion, if each has the more frequent
// outcome.
int runs_to_settle(CriterionResult r) {
  if (r.runs == 0) return 1;
  const bool mostly = 2 * r.holds >= r.runs;
  for (int more = 1; more <= 1000; ++more) {
    r.holds += mostly;
    ++r.runs;
    r.probability = probability_of(r);
    if (judge_criterion(r) != ValidationVerdict::inconclusive) return more;
  }
  return 1000;
}

CriterionResult evaluate_criterion(const Criterion& criterion, const RunGroup& base) {
  CriterionResult r;
  r.criterion = criterion;
  const ResponseExpression lhs = parse_response_expression(criterion.lhs),
                           rhs = parse_response_expression(criterion.rhs);
  for (const JobResult& run : base.results) {
    std::optional<bool> holds;
    if (run.status == JobStatus::finished) {
      r.lhs.push_back(
          with_place(criterion.lhs_place, [&] { return evaluate(lhs, run.responses); }));
      r.rhs.push_back(
          with_place(criterion.rhs_place, [&] { return evaluate(rhs, run.responses); }));
      r.unit = unit_of(lhs, run.responses);
      if (!std::isnan(r.lhs.back()) && !std::isnan(r.rhs.back()))
        holds = r.lhs.back() > criterion.factor * r.rhs.back();
    } else if (run.status == JobStatus::failed && criterion.if_run_fails) {
      holds = criterion.if_run_fails;
      ++r.failed;
    }
    r.missing += !holds;
    r.runs += holds.has_value();
    r.holds += holds.value_or(false);
  }
  r.probability = probability_of(r);
  r.verdict = judge_criterion(r);
  return r;
}

// Counts of all runs together, and how the share of each class scatters over the runs: as a
// multinomial's at least, since few runs may happen to agree.
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
  double all = 0;
  for (const double n : d.simulated) all += n;
  const double a_run = all / static_cast<double>(runs.size());
  for (std::size_t k = 0; k < classes; ++k) {
    const double p = all > 0 ? d.simulated[k] / all : 0;
    const double multinomial = a_run > 0 ? std::sqrt(p * (1 - p) / a_run) : 0;
    d.deviation.push_back(std::fmax(sample_statistics(shares[k]).deviation, multinomial));
  }
  if (d.classes.empty())
    for (std::size_t k = 1; k <= classes; ++k) d.classes.push_back(std::to_string(k));
}

// The companion of residence times: how long what has not passed has been inside.
std::vector<double> still_inside(const JobResult& run, const std::string& response) {
  constexpr std::string_view times = "_residence_times", censored = "_censored_times";
  if (!response.ends_with(times)) return {};
  const std::string name =
      response.substr(0, response.size() - times.size()) + std::string(censored);
  const auto found = std::ranges::find(run.responses, name, &Response::name);
  return found == run.responses.end() ? std::vector<double>{} : found->value;
}

bool any_open(const DistributionResult& d) {
  return !d.simulated_at_least.empty() || !d.measured_at_least.empty();
}

void take(const SampleTest& t, DistributionResult& d) {
  d.distance = t.distance;
  d.p_value = t.p;
  d.area = t.area;
  d.area_p_value = t.area_p;
  d.critical = t.critical;
  d.dependent = t.dependent;
}

void judge_classes(const std::vector<std::vector<double>>& runs, DistributionResult& d) {
  const ShareTest t = compare_shares(runs, d.measured);
  d.distance = t.distance;
  d.p_value = t.p;
  d.critical = t.critical;
  d.dispersion = t.dispersion;
}

// `runs`: values or counts of each; `inside`: values of each that are only known to be larger.
void judge_distribution(const ValuesByRun& runs, const ValuesByRun& inside, DistributionResult& d) {
  const auto any = [](const std::vector<double>& values, const std::vector<double>& open,
                      bool by_class) {
    return !open.empty() ||
           std::ranges::any_of(values, [&](double v) { return !by_class || v > 0; });
  };
  if (!any(d.simulated, d.simulated_at_least, d.by_class) ||
      !any(d.measured, d.measured_at_least, d.by_class))
    return;
  if (d.by_class) {
    judge_classes(runs, d);
  } else if (any_open(d)) {
    std::vector<CensoredTimes> times;
    for (std::size_t r = 0; r < runs.size(); ++r) times.push_back({runs[r], inside[r]});
    take(compare_open_times(times, {d.measured, d.measured_at_least}), d);
  } else {
    take(compare_samples(runs, d.measured), d);
  }
  if (!d.by_class) {
    std::vector<double> all = d.simulated;
    all.insert(all.end(), d.measured.begin(), d.measured.end());
    d.apart = value_apart(all);
  }
  d.verdict = d.p_value < improbable             ? ValidationVerdict::inconsistent
              : d.apart || !(d.critical <= half) ? ValidationVerdict::inconclusive
                                                 : ValidationVerdict::consistent;
}

DistributionResult compare_distribution(const MeasuredData& data, const RunGroup& base) {
  DistributionResult d;
  d.response = data.response;
  d.by_class = data.kind == MeasuredData::Kind::classes;
  d.unit = unit_of(data);
  d.classes = data.classes;
  d.measured = d.by_class ? data.counts : data.values;
  if (!d.by_class) std::ranges::sort(d.measured);
  std::vector<const Response*> runs;
  for (const JobResult* run : base.finished()) runs.push_back(&response_of(*run, data));
  if (d.by_class) add_counts(runs, d);
  ValuesByRun by_run, inside;
  for (const Response* r : runs) by_run.push_back(d.by_class ? r->value : defined(r->value));
  for (const JobResult* run : base.finished()) inside.push_back(still_inside(*run, d.response));
  const auto sorted = [](const ValuesByRun& values) {
    std::vector<double> all;
    for (const auto& v : values) all.insert(all.end(), v.begin(), v.end());
    std::ranges::sort(all);
    return all;
  };
  if (!d.by_class) d.simulated = sorted(by_run);
  d.measured_at_least = data.right_censored;
  d.simulated_at_least = sorted(inside);
  if (data.present)
    judge_distribution(by_run, inside, d);
  else
    d.verdict = ValidationVerdict::not_judged;
  return d;
}

// End of the headline: an outlier, too few values, or the smallest distance that would be found.
std::string open_words(const DistributionResult& d) {
  if (d.apart)
    return fmt::format("; {} stands apart from all other values", rounded_text(*d.apart, d.unit));
  if (d.critical > half)
    return fmt::format("; too few values: {}",
                       d.critical > 1 ? "no distance would be too large for chance"
                                      : fmt::format("chance alone reaches {:.2g}", d.critical));
  return fmt::format("; a distance of {:.2g} could hide in this", d.critical);
}

std::string distribution_words(const DistributionResult& d) {
  if (d.simulated.empty() && d.simulated_at_least.empty()) return "no run gave values";
  if (d.measured.empty() && d.measured_at_least.empty()) return "the experiment gave no values";
  const std::string what =
      d.by_class    ? "share that would have to be exchanged"
      : any_open(d) ? "largest distance of the shares that have passed (Kaplan and Meier)"
                    : "largest distance of the cumulative distributions";
  const std::string area =
      d.by_class || any_open(d) ? "" : fmt::format(" (area {:.3g} {})", d.area, d.unit);
  return fmt::format("{}: {:.2g}{}, which chance alone exceeds in {:.2g} % of all cases{}", what,
                     d.distance, area, 100 * d.p_value,
                     d.verdict == ValidationVerdict::inconsistent ? "" : open_words(d));
}

std::string distribution_remedy(const DistributionResult& d) {
  if (d.simulated.empty() && d.simulated_at_least.empty()) return "runs that finish";
  if (d.apart)
    return fmt::format("why one value is {}, or more values", rounded_text(*d.apart, d.unit));
  if (d.dependent)
    return "more runs and more experiments: values of one run are alike, so that runs count";
  return "more values, measured and simulated";
}

void add_caveats(const DistributionResult& d, std::size_t runs, Comparison& c) {
  if (d.dependent)
    c.caveats.emplace_back(
        "values of one run are alike: the experiment is compared as one run among the others");
  else if (d.by_class && d.dispersion > 1)
    c.caveats.push_back(fmt::format(
        "counts scatter {:.2g} times as much from run to run as independent ones", d.dispersion));
  else if (runs < 2)
    c.caveats.emplace_back("one run: its values are taken as independent of each other");
}

// Verdicts of the single statements.
struct CriterionCounts {
  int all = 0, consistent = 0, inconsistent = 0;
  int runs_to_settle = 0;  // of the statement that needs the most
  int open() const { return all - consistent - inconsistent; }
  std::string words() const {
    return fmt::format(
        "of {} statement{}, {} hold{} in the simulation, {} do{} not, {} stay{} open", all,
        all == 1 ? "" : "s", consistent, consistent == 1 ? "s" : "", inconsistent,
        inconsistent == 1 ? "es" : "", open(), open() == 1 ? "s" : "");
  }
};

CriterionCounts evaluate_criteria(const SuiteComparison& what, const RunGroup& base,
                                  Comparison& c) {
  CriterionCounts counts;
  for (const Criterion& criterion : what.measurement.criteria) {
    const CriterionResult r = evaluate_criterion(criterion, base);
    ++counts.all;
    counts.consistent += r.verdict == ValidationVerdict::consistent;
    counts.inconsistent += r.verdict == ValidationVerdict::inconsistent;
    if (r.verdict == ValidationVerdict::inconclusive)
      counts.runs_to_settle = std::max(counts.runs_to_settle, runs_to_settle(r));
    if (r.failed > 0)
      c.caveats.push_back(fmt::format("\"{}\" {} in a run that fails, as the measurement states",
                                      criterion.statement,
                                      *criterion.if_run_fails ? "holds" : "does not hold"));
    if (r.missing > 0)
      c.caveats.push_back(
          fmt::format("\"{}\": {} of {} runs have no answer; the verdict allows for either",
                      criterion.statement, r.missing, r.missing + r.runs));
    c.criteria.push_back(r);
  }
  return counts;
}

// Adds a distribution with measured numbers to headline, caveats and recommendation. `finished`:
// runs of the base. `judged`: these are enough.
void report_distribution(const RunGroup& base, std::size_t finished, bool judged, Comparison& c) {
  c.headline += "; " + distribution_words(*c.distribution);
  if (!judged) c.headline += "; " + missing_words(base, base.results.size() - finished);
  add_caveats(*c.distribution, finished, c);
  if (c.distribution->verdict == ValidationVerdict::inconclusive)
    c.recommended_action = judged ? distribution_remedy(*c.distribution) : "runs that finish";
}

void recommend_runs(int runs_to_settle, Comparison& c) {
  if (runs_to_settle > 0)
    c.recommended_action += fmt::format("{}at least {} more run{} with other seeds",
                                        c.recommended_action.empty() ? "" : "; ", runs_to_settle,
                                        runs_to_settle == 1 ? "" : "s");
  else if (c.verdict == ValidationVerdict::inconclusive && c.recommended_action.empty())
    c.recommended_action = "more runs with other seeds";
}

}  // namespace

void compare_criteria(const SuiteComparison& what, const ComparisonRuns& e, Comparison& c) {
  const CriterionCounts counts = evaluate_criteria(what, *e.base, c);
  c.headline = counts.words();
  const auto& data = what.measurement.data;
  if (data) c.distribution = compare_distribution(*data, *e.base);
  const bool numbers = data && data->present;
  const std::size_t runs = e.base->results.size(), finished = e.base->finished().size();
  const bool judged = numbers && !too_many_missing(runs - finished, runs);
  if (numbers && !judged) c.distribution->verdict = ValidationVerdict::inconclusive;
  // Several statements, each wrong by chance in 5 % of all cases: the smallest probability times
  // their number (Bonferroni) is that of the verdict.
  double least = 1;
  for (const CriterionResult& r : c.criteria) least = std::min(least, p_against(r));
  if (judged) least = std::min(least, c.distribution->p_value);
  const int statements = counts.all + (numbers ? 1 : 0);
  const double together = least * statements;
  const bool all_hold = counts.consistent == counts.all &&
                        (!numbers || c.distribution->verdict == ValidationVerdict::consistent);
  c.verdict = together <= improbable ? ValidationVerdict::inconsistent
              : all_hold             ? ValidationVerdict::consistent
                                     : ValidationVerdict::inconclusive;
  if (numbers)
    report_distribution(*e.base, finished, judged, c);
  else if (data)
    c.caveats.push_back(
        fmt::format("the experiment's numbers are not here; as {} they would be "
                    "compared",
                    data->file));
  if (c.verdict == ValidationVerdict::inconclusive && least <= improbable)
    c.headline += fmt::format(
        "; among {} statements chance alone gives as much in up to {:.2g} % of all cases",
        statements, 100 * std::min(1.0, together));
  recommend_runs(counts.runs_to_settle, c);
}

}  // namespace firn::comparison
