// What a calibration concludes from its models: the estimate, its confirmation and the verdict.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "calibrate/calibration.h"
#include "calibrate/numerics/experimental_design.h"

namespace firn {
namespace {

using Eigen::VectorXd;

// Seeds at the ends of the ridge start this far above the study's: never used before.
constexpr std::uint64_t ridge_seeds = 2000, ridge_seed_stride = 500;
// How many standard deviations still count as agreement.
constexpr double agreement = 2;

constexpr int sobol_samples = 2048;

// Standard error of the mean of `s`, from the pooled noise and the spread of `s`, weighted by their
// degrees of freedom. Where the noise is not uniform, the local noise at `u` is used if it is
// larger: a few seeds may agree by chance.
double standard_error(const ResponseModels* fitted, const ResponseId& response, const VectorXd& u,
                      const Sample& s) {
  if (s.count == 0) return std::numeric_limits<double>::quiet_NaN();
  const double own_freedom = s.count - 1;
  double variance = s.sum_of_squares / own_freedom, freedom = own_freedom, local_variance = 0;
  if (fitted != nullptr)
    for (const auto* models : {&fitted->targets, &fitted->observed})
      for (const ResponseModel& m : *models) {
        if (m.response.label != response.label) continue;
        const double pooled = std::pow(m.noise.at(s.mean), 2);
        freedom = own_freedom + m.noise.degrees_of_freedom;
        variance = (s.sum_of_squares + m.noise.degrees_of_freedom * pooled) / freedom;
        std::vector<NoiseSite> sites = m.noise_sites;
        if (s.count >= 2 && pooled > 0)
          sites.push_back({u, s.sum_of_squares / pooled, own_freedom});
        const LocalNoise local(std::move(sites));
        if (!local.uniform())
          local_variance = widened_variance(local.factor(u) * pooled, local.freedom(u));
      }
  return std::sqrt(std::max(widened_variance(variance, freedom), local_variance) / s.count);
}

Sensitivity sensitivity_of(const ResponseModel& m, int d) {
  const auto f = [&](const VectorXd& u) { return m.surrogate.best.predict_mean(u); };
  Sensitivity s{m.response.label, sobol_indices(f, d, sobol_samples), 0};
  // The intervals include the indices of the other kind of model.
  const SobolIndices other = sobol_indices(
      [&](const VectorXd& u) { return m.surrogate.other.predict_mean(u); }, d, sobol_samples);
  const auto widen = [](Eigen::MatrixX2d& interval, const VectorXd& estimate) {
    interval.col(0) = interval.col(0).cwiseMin(estimate);
    interval.col(1) = interval.col(1).cwiseMax(estimate);
  };
  widen(s.indices.first_interval, other.first);
  widen(s.indices.total_interval, other.total);
  s.noise_share = std::pow(m.noise.at(f(VectorXd::Constant(d, 0.5))), 2) / s.indices.variance;
  return s;
}

}  // namespace

void observe(const Study& study, const ResponseModels* fitted, const Point& point,
             CheckedSet& set) {
  set.finished = point.count(JobStatus::finished);
  set.arched = point.count(JobStatus::arched);
  set.failed = point.count(JobStatus::failed) + point.count(JobStatus::crashed);
  set.cut_short = point.count(JobStatus::timed_out) + point.count(JobStatus::out_of_memory);
  const auto add = [&](const ResponseId& response) {
    const Sample s = sample(point.finished(response));
    set.observed.push_back(
        {response.label, point.unit(response), s, standard_error(fitted, response, point.u, s)});
  };
  for (const Target& t : study.targets) add(t.response);
  for (const Observed& o : study.observed) add(o.response);
}

// Whether all targets can be met together, and the range of each.
void Calibration::judge_fit() {
  const bool priors = prior_count(study_.priors, study_.parameters) > 0;
  a_.goodness = goodness_of_fit(study_, *a_.models, best_, Priors::with);
  a_.without_priors.reset();
  if (priors) a_.without_priors = goodness_of_fit(study_, *a_.models, best_, Priors::without);
  a_.reach.clear();
  const int d = static_cast<int>(study_.parameters.size());
  for (std::size_t k = 0; k < study_.targets.size(); ++k) {
    const Target& t = study_.targets[k];
    const ResponseModel& m = a_.models->targets[k];
    ReachedRange r{m.lowest, m.highest, m.lowest <= t.value && t.value <= m.highest, false};
    const auto look = [&](const VectorXd& u) {
      if (!allowed(study_.constraints, study_.parameters, u)) return;
      const Prediction p = m.surrogate.best.predict(u);
      r.lowest = std::min(r.lowest, p.mean);
      r.highest = std::max(r.highest, p.mean);
      const double sd = std::hypot(t.sd(), std::sqrt(p.variance));
      r.reachable = r.reachable || std::abs(p.mean - t.value) <= agreement * sd;
    };
    look(best_);
    for (std::uint64_t i = 0; i < 4096; ++i) look(quasi_random_point(i, d));
    // The quasi-random points never are a corner.
    if (d <= 10)
      for (int corner = 0; corner < 1 << d; ++corner) {
        VectorXd u(d);
        for (int i = 0; i < d; ++i) u[i] = corner >> i & 1;
        look(u);
      }
    a_.reach.push_back(r);
  }
}

// To be called before the confirmation, whose runs must not affect the choice.
void Calibration::choose_estimate() {
  if (!a_.goodness->acceptable()) best_ = a_.goodness->u;
  const std::vector<double> values = allowed_values(study_.constraints, study_.parameters, best_);
  best_ = to_unit(study_.parameters, values);
  a_.best = checked(a_.goodness->acceptable() ? "answer" : "nearest",
                    study_runs_.point("confirm", 0, values, {}));
  for (const ResponseModel& m : a_.models->targets)
    a_.cross_check.push_back(m.surrogate.other.predict_mean(best_));
  a_.combinations = combinations(study_, *a_.models, best_);
  judge_identifiability();
}

void Calibration::judge_identifiability() {
  const bool all_identified = std::all_of(a_.combinations.begin(), a_.combinations.end(),
                                          [](const Combination& c) { return c.identifiable; });
  a_.verdict = all_identified ? StudyVerdict::calibrated : StudyVerdict::not_identifiable;
  if (all_identified) a_.ridge.clear();
  if (all_identified || !a_.ridge.empty()) return;
  const NegativeLogPosterior misfit(study_, *a_.models);
  for (const RidgeMember& member : ridge(study_, misfit, *a_.posterior))
    a_.ridge.push_back(checked(fmt::format("member {}", a_.ridge.size() + 1),
                               study_runs_.point("valley", 0, member.values, {})));
}

// Final models, from all runs including the confirmation runs. These are replicates at one point
// and determine the noise at the estimate.
void Calibration::summarize_posterior(const std::vector<Point>& elsewhere) {
  a_.models = fit_response_models(study_, a_.points, elsewhere);
  const NegativeLogPosterior misfit(study_, *a_.models);
  a_.posterior = sample_posterior(study_, misfit);
  record_estimate("confirmation");
  for (const ResponseModel& m : a_.models->targets)
    a_.predictive.push_back(posterior_predictive(m, *a_.posterior));
  a_.combinations = combinations(study_, *a_.models, best_);
  rms_over_posterior(*a_.posterior, study_, a_.combinations);
  judge_identifiability();
  for (std::size_t k = 0; k < study_.targets.size(); ++k) {
    const Prediction p = a_.models->targets[k].surrogate.best.predict_with_noise(best_);
    a_.split.push_back({std::pow(study_.targets[k].uncertainty, 2), p.noise_variance,
                        p.variance - p.noise_variance, std::pow(study_.targets[k].discrepancy, 2)});
  }
  a_.profiles = profile_likelihoods(study_, misfit, *a_.posterior);
  a_.advice = rank_measurements(study_, *a_.models, *a_.posterior);
  a_.cut_short_share = a_.models->cut_short_probability(best_);
  judge_fit();
  if (!a_.goodness->acceptable()) {
    const bool by_priors = a_.without_priors && a_.without_priors->acceptable();
    a_.verdict = by_priors ? StudyVerdict::prior_conflict : StudyVerdict::infeasible;
  } else if (!agrees(a_.best)) {
    a_.verdict = StudyVerdict::unconfirmed;
  }
  if (!a_.outliers.empty())
    a_.caveats.push_back(a_.outliers.size() == 1
                             ? "one outlier run was left out"
                             : fmt::format("{} outlier runs were left out", a_.outliers.size()));
  for (std::size_t k = 0; k < study_.targets.size(); ++k)
    if (const Observation& o = a_.best.observed[k];
        o.standard_error > agreement * study_.targets[k].sd())
      a_.caveats.push_back(
          fmt::format("{} is confirmed to ± {:.2g} only, and was measured to ± {:.2g}", o.response,
                      o.standard_error, study_.targets[k].uncertainty));
  for (std::size_t i = 0; i < a_.curves.size(); ++i)
    if (has_unexplained_part(study_.curves[i], a_.curves[i]))
      a_.caveats.push_back(fmt::format(
          "the recorded curve {} has a part that no simulated curve has", study_.curves[i].label));
  for (const ResponseModel& m : a_.models->targets)
    if (!m.passes_cross_validation())
      a_.caveats.push_back(
          fmt::format("the model of {} does not explain its own runs", m.response.label));
}

void Calibration::confirm() {
  const Budget& b = study_.budget;
  int seeds = b.confirmation_replicates;
  // Remaining runs of the budget become confirmation runs: all of them if no batch can use them,
  // else up to twice the stated number.
  if (b.runs > 0 && !b.rounds_stated) {
    const int left = seeds_left() - (a_.ridge.empty() ? 0 : 2 * b.endpoint_replicates);
    seeds = std::max(seeds, budget_used_ ? left : std::min(left, 2 * b.confirmation_replicates));
  }
  std::uint64_t first = study_.seed + confirm_seeds;
  // Another study may have confirmed the same parameters: its runs are in the fit.
  for (const Point& p : a_.points)
    if (p.values == a_.best.values)
      for (const std::uint64_t seed : p.seeds) first = std::max(first, seed + 1);
  std::vector<Point> batch = {
      study_runs_.point("confirm", 0, a_.best.values, seed_list(first, seeds))};
  progress_.phase("confirming with fresh seeds");
  run(batch);
  a_.points.push_back(batch[0]);
  a_.outliers = mark_outliers(study_, a_.points);
  observe(study_, &*a_.models, a_.points.back(), a_.best);
}

void Calibration::check_ridge_ends() {
  if (a_.ridge.empty() || study_.budget.endpoint_replicates == 0) return;
  std::vector<CheckedSet*> ends = {&a_.ridge.front(), &a_.ridge.back()};
  std::vector<Point> batch;
  for (std::size_t i = 0; i < ends.size(); ++i)
    batch.push_back(study_runs_.point("valley end", static_cast<int>(i), ends[i]->values,
                                      seed_list(study_.seed + ridge_seeds + i * ridge_seed_stride,
                                                study_.budget.endpoint_replicates)));
  progress_.phase("checking the ends of the ridge");
  run(batch);
  a_.points.insert(a_.points.end(), batch.begin(), batch.end());
  a_.outliers = mark_outliers(study_, a_.points);
  for (std::size_t i = 0; i < ends.size(); ++i)
    observe(study_, &*a_.models, a_.points[a_.points.size() - ends.size() + i], *ends[i]);
}

CheckedSet Calibration::checked(const std::string& name, const Point& point) const {
  CheckedSet set;
  set.name = name;
  set.values = point.values;
  if (a_.models)
    for (const ResponseModel& m : a_.models->targets)
      set.predicted.push_back(m.surrogate.best.predict(point.u));
  if (!point.results.empty()) observe(study_, a_.models ? &*a_.models : nullptr, point, set);
  return set;
}

// One test of all targets together, so that the false alarm rate does not grow with their number.
bool Calibration::agrees(const CheckedSet& set) const {
  constexpr double significance = 0.05;
  double chi_square = 0;
  for (std::size_t k = 0; k < study_.targets.size(); ++k) {
    const Target& t = study_.targets[k];
    const Observation& o = set.observed[k];
    if (o.sample.count < 2) return false;
    chi_square += std::pow((o.sample.mean - t.value) / std::hypot(t.sd(), o.standard_error), 2);
  }
  return chi_square_tail(chi_square, static_cast<double>(study_.targets.size())) >= significance;
}

// What the low fidelity changed at the estimate, and what runs of both forms took.
void Calibration::describe_fidelity() {
  if (!study_.low_fidelity) return;
  FidelityOutcome outcome;
  if (a_.models && best_.size() > 0)
    for (const auto* models : {&a_.models->targets, &a_.models->observed})
      for (const ResponseModel& m : *models)
        if (study_.low_fidelity->applies(m.response.experiment))
          outcome.biases.push_back(
              {m.response.label, m.unit, m.surrogate.best.fidelity_bias(best_)});
  std::set<std::string> counted;  // keys: points may share runs
  for (const Point& p : a_.points)
    for (std::size_t e = 0; e < p.results.size(); ++e)
      for (std::size_t s = 0; s < p.results[e].size(); ++s) {
        if (!study_.low_fidelity->applies(e) || !counted.insert(p.keys[e][s]).second) continue;
        FidelityOutcome::Runs& runs = p.is_low_fidelity(e) ? outcome.low : outcome.high;
        ++runs.count;
        runs.wall += p.results[e][s].wall;
      }
  a_.fidelity = outcome;
}

// Shifts by each numerics check, against the runs at the middle.
void Calibration::compare_numerics() {
  const auto center = std::find_if(a_.points.begin(), a_.points.end(),
                                   [](const Point& p) { return p.phase == "center"; });
  const ResponseModels* fitted = a_.models ? &*a_.models : nullptr;
  for (std::size_t i = 0; i < numerics_.size(); ++i) {
    NumericsOutcome outcome{study_.numerics[i].name, {}};
    const auto compare = [&](const ResponseId& response) {
      const Sample there = sample(numerics_[i].finished(response));
      const Sample here = sample(center->finished(response));
      if (there.count == 0 || here.count == 0) return;
      outcome.shifts.push_back({response.label, center->unit(response), there.mean - here.mean,
                                std::hypot(standard_error(fitted, response, center->u, there),
                                           standard_error(fitted, response, center->u, here))});
    };
    for (const Target& t : study_.targets) compare(t.response);
    for (const Observed& o : study_.observed) compare(o.response);
    a_.numerics.push_back(outcome);
  }
}

std::string Calibration::misfit_text() const {
  std::vector<std::string> missed;
  for (std::size_t k = 0; k < study_.targets.size(); ++k)
    if (const ReachedRange& r = a_.reach[k]; !r.reachable)
      missed.push_back(fmt::format("{} = {:.4g} {} (the ranges give {:.4g} to {:.4g})",
                                   study_.targets[k].response.label, study_.targets[k].value,
                                   study_.targets[k].unit, r.lowest, r.highest));
  if (!missed.empty())
    return fmt::format("infeasible within the ranges: {}", fmt::join(missed, "; "));
  const GoodnessOfFit& g = *a_.goodness;
  const auto farthest = std::max_element(
      g.z.begin(), g.z.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
  return fmt::format(
      "no parameters within the ranges meet all targets at once: chi-square {:.1f} on {:.1f} "
      "degrees of freedom (probability {:.2g}); farthest is {}, {:.1f} standard deviations {}",
      g.chi_square, g.freedom, g.probability,
      study_.targets[static_cast<std::size_t>(farthest - g.z.begin())].response.label,
      std::abs(*farthest), *farthest > 0 ? "too high" : "too low");
}

// Why the first run without responses has none; empty when all have some.
std::string Calibration::failure_text() const {
  int without = 0, all = 0;
  std::string reason;
  for (const Point& p : a_.points)
    for (const std::vector<JobResult>& experiment : p.results)
      for (const JobResult& r : experiment) {
        ++all;
        if (r.status == JobStatus::finished || r.status == JobStatus::arched) continue;
        if (++without == 1) reason = r.reason;
      }
  if (without == 0) return "";
  return fmt::format(": {} of {} did not finish, the first because of: {}", without, all, reason);
}

void Calibration::account_for_budget() {
  const int experiments = static_cast<int>(study_.experiments.size());
  a_.budget_runs = study_.budget.runs * experiments;
  if (a_.budget_runs == 0) return;
  a_.budget_left = std::max(0, seeds_left()) * experiments;
  if (a_.budget_left == 0) return;
  a_.left_because = study_.budget.rounds_stated ? "the study states the rounds of refinement"
                    : budget_used_              ? "they are too few for another point"
                                                : "they were not needed";
}

// The parameter sets of [[compare]]. After the final fit: they need its noise and its predictions.
void Calibration::compare_sets() {
  for (const CompareSet& set : study_.compare) {
    Point point = study_runs_.point(kComparePhase + set.name, 0, set.values, {});
    for (const Point& p : a_.points)
      if (p.phase == point.phase) point = p;
    a_.compare.push_back(checked(set.name, point));
    if (a_.posterior && point.u.minCoeff() >= 0 && point.u.maxCoeff() <= 1)
      a_.compare.back().hpd_level =
          a_.posterior->hpd_level(NegativeLogPosterior(study_, *a_.models).cost(point.u));
  }
}

void Calibration::analyze_sensitivity() {
  if (!a_.models) return;
  const int d = static_cast<int>(study_.parameters.size());
  for (const auto* models : {&a_.models->targets, &a_.models->observed})
    for (const ResponseModel& m : *models) a_.sensitivity.push_back(sensitivity_of(m, d));
}

// The first sentence of the report, without caveats.
std::string Calibration::headline() const {
  switch (a_.verdict) {
    case StudyVerdict::calibrated:
      return fmt::format("calibrated: {}", parameter_text(study_, a_.best.values));
    case StudyVerdict::not_identifiable:
      return fmt::format(
          "the targets are met along a ridge of equally good parameters; one member: {}",
          parameter_text(study_, a_.best.values));
    case StudyVerdict::unconfirmed:
      return fmt::format(
          "not confirmed: fresh runs at {} {}", parameter_text(study_, a_.best.values),
          a_.best.cut_short > 0 ? "were cut short by a limit" : "do not meet the targets");
    case StudyVerdict::infeasible:
      return misfit_text();
    case StudyVerdict::prior_conflict:
      return fmt::format(
          "the priors conflict with the targets: together chi-square {:.1f} on {:.1f} degrees of "
          "freedom (probability {:.2g}), the targets alone {:.1f} on {:.1f}; nearest by both: {}",
          a_.goodness->chi_square, a_.goodness->freedom, a_.goodness->probability,
          a_.without_priors->chi_square, a_.without_priors->freedom,
          parameter_text(study_, a_.best.values));
    case StudyVerdict::too_few_runs:
      return "too few runs finished to fit anything" + failure_text();
    case StudyVerdict::direct_search_only:
    case StudyVerdict::interrupted:
      break;
  }
  return "";
}

CalibrationResult Calibration::finish() {
  compare_sets();
  compare_numerics();
  describe_fidelity();
  analyze_sensitivity();
  account_for_budget();
  a_.headline = headline();
  for (const std::string& caveat : a_.caveats) a_.headline += "; " + caveat;
  if (!study_.curves.empty()) a_.study = std::make_shared<const Study>(study_);
  return std::move(a_);
}

}  // namespace firn
