#include "calibrate/calibration.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "calibrate/numerics/experimental_design.h"

namespace firn {
namespace {

using Eigen::VectorXd;

// Seeds of the anchors start this far above the study's: never used before.
constexpr std::uint64_t anchor_seeds = 2000, anchor_stride = 500;
// Phases of the runs that are asked for by name.
const std::string compare_phase = "compare: ";
// How many standard deviations still count as agreement.
constexpr double agreement = 2;

constexpr int sobol_samples = 2048;

double wall_of(const std::vector<Point>& points) {
  double sum = 0;
  for (const Point& p : points) sum += p.wall();
  return sum;
}

// By the pooled noise and this sample's own spread, each with its degrees of freedom; where the
// noise is not uniform, this sample among them, by that of the neighbourhood if it is larger: few
// seeds that happen to agree are no proof of a quiet place.
double standard_error(const ResponseModels* knowledge, const ResponseId& response,
                      const VectorXd& u, const Sample& s) {
  if (s.count == 0) return std::numeric_limits<double>::quiet_NaN();
  const double own_freedom = s.count - 1;
  double variance = s.sum_of_squares / own_freedom, freedom = own_freedom, local_variance = 0;
  if (knowledge != nullptr)
    for (const auto* models : {&knowledge->targets, &knowledge->observed})
      for (const ResponseModel& m : *models) {
        if (m.response.label != response.label) continue;
        const double pooled = std::pow(m.noise.at(s.mean), 2);
        freedom = own_freedom + m.noise.degrees_of_freedom;
        variance = (s.sum_of_squares + m.noise.degrees_of_freedom * pooled) / freedom;
        std::vector<NoiseSite> sites = m.noise_sites;
        if (s.count >= 2 && pooled > 0)
          sites.push_back({u, s.sum_of_squares / pooled, own_freedom});
        const LocalNoise local(std::move(sites));
        if (!local.uniform()) local_variance = widened(local.factor(u) * pooled, local.freedom(u));
      }
  return std::sqrt(std::max(widened(variance, freedom), local_variance) / s.count);
}

}  // namespace

std::vector<std::uint64_t> seed_range(std::uint64_t first, int count) {
  std::vector<std::uint64_t> s;
  s.reserve(static_cast<std::size_t>(std::max(count, 0)));
  for (int i = 0; i < count; ++i) s.push_back(first + static_cast<std::uint64_t>(i));
  return s;
}

std::string parameter_text(const Study& study, const std::vector<double>& values) {
  std::vector<std::string> parts;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Parameter& p = study.parameters[i];
    parts.push_back(
        fmt::format("{} = {}{}{}", p.name, p.text(values[i]), p.unit.empty() ? "" : " ", p.unit));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

void observe(const Study& study, const ResponseModels* knowledge, const Point& point,
             CheckedSet& set) {
  set.finished = point.count(JobStatus::finished);
  set.arched = point.count(JobStatus::arched);
  set.failed = point.count(JobStatus::failed) + point.count(JobStatus::crashed);
  set.cut_short = point.count(JobStatus::timed_out) + point.count(JobStatus::out_of_memory);
  const auto add = [&](const ResponseId& response) {
    const Sample s = sample(point.finished(response));
    set.observed.push_back(
        {response.label, point.unit(response), s, standard_error(knowledge, response, point.u, s)});
  };
  for (const Target& t : study.targets) add(t.response);
  for (const Observed& o : study.observed) add(o.response);
}

// The named sets, and the middle of the ranges with the case's numerics and with others. Points
// share their seeds: the same packing where the parameters allow it.
void Calibration::run_initial_design() {
  const Budget& b = study_.budget;
  const std::vector<double> middle =
      allowed_values(study_.constraints, study_.parameters, study_.constraints.middle);
  std::vector<Point> points;
  for (std::size_t i = 0; i < study_.compare.size() && b.compare_replicates > 0; ++i)
    points.push_back(campaign_.point(compare_phase + study_.compare[i].name, static_cast<int>(i),
                                     study_.compare[i].values,
                                     seed_range(study_.seed, b.compare_replicates)));
  points.push_back(
      campaign_.point("centre", 0, middle, seed_range(study_.seed, b.center_replicates)));
  for (const NumericsCheck& check : study_.numerics) {
    numerics_.push_back(campaign_.point("numerics: " + check.name,
                                        static_cast<int>(numerics_.size()), middle,
                                        seed_range(study_.seed, b.numerics_replicates)));
    numerics_.back().set = check.set;
    numerics_.back().only = check.only;
  }
  // What others have run comes first; a run counts at one point only.
  std::vector<Point> reused = reused_points();
  for (Point& p : reused)
    for (const Point& asked : points)
      if (p.values == asked.values)
        std::erase_if(p.seeds, [&](std::uint64_t seed) {
          return std::find(asked.seeds.begin(), asked.seeds.end(), seed) != asked.seeds.end();
        });
  std::erase_if(reused, [](const Point& p) { return p.seeds.empty(); });
  reused_ = reused.size();
  points.insert(points.begin(), reused.begin(), reused.end());
  // In one batch, so that no process waits for the slowest run of either.
  const auto asked = static_cast<std::ptrdiff_t>(points.size());
  points.insert(points.end(), numerics_.begin(), numerics_.end());
  progress_.phase("noise and numerics");
  campaign_.run(points);
  numerics_.assign(points.begin() + asked, points.end());
  points.erase(points.begin() + asked, points.end());
  a_.points = std::move(points);
  for (const Point& p : reused) a_.reused += static_cast<int>(p.seeds.size());
  a_.reused *= static_cast<int>(study_.experiments.size());
  spread_design();
}

std::vector<Point> Calibration::reused_points() {
  const Budget& b = study_.budget;
  if (!b.reuse || b.runs == 0 || b.rounds_stated) return {};
  const int most = b.runs - b.center_replicates - b.confirmation_replicates;
  return campaign_.reusable(most * static_cast<int>(study_.experiments.size()));
}

// A design that fills the ranges.
void Calibration::spread_design() {
  const Budget& b = study_.budget;
  const bool traded = b.allow_single_replicate && noise_is_negligible();
  replicates_per_point_ = traded ? 1 : b.replicates_per_point;
  point_multiplier_ = traded ? b.replicates_per_point : 1;
  std::vector<VectorXd> taken;
  for (const Point& p : a_.points) taken.push_back(p.u);
  std::vector<Point> design;
  const int planned = b.design_points * point_multiplier_;
  int count = planned - std::min(planned, static_cast<int>(reused_));
  if (reused_ > 0)
    count =
        std::clamp((seeds_left() - b.confirmation_replicates) / replicates_per_point_, 0, count);
  const int d = static_cast<int>(study_.parameters.size());
  if (count == 0) return;
  for (const VectorXd& u : study_.constraints.all.empty()
                               ? maximin_latin_hypercube(count, d, study_.seed, taken)
                               : spread_points(study_.constraints, study_.parameters, count, taken))
    design.push_back(campaign_.point("design", static_cast<int>(design.size()),
                                     allowed_values(study_.constraints, study_.parameters, u),
                                     seed_range(study_.seed, replicates_per_point_)));
  progress_.phase("exploring the ranges");
  campaign_.run(design);
  a_.points.insert(a_.points.end(), design.begin(), design.end());
}

// Whether seeds at the middle differ by less than what each measurement is uncertain by.
bool Calibration::noise_is_negligible() const {
  const Point& centre = a_.points.back();
  return std::all_of(study_.targets.begin(), study_.targets.end(), [&](const Target& t) {
    const Sample s = sample(centre.finished(t.response));
    return s.count >= 2 && s.sd() < t.uncertainty;
  });
}

// Seeds of all experiments together, as shares of a point's: a numerics check may be of one alone.
int Calibration::seeds_left() const {
  const int experiments = static_cast<int>(study_.experiments.size());
  int runs = 0;
  for (const auto* points : {&a_.points, &numerics_})
    for (const Point& p : *points)
      runs += static_cast<int>(p.seeds.size()) * (p.only ? 1 : experiments);
  return study_.budget.runs - (runs + experiments - 1) / experiments;
}

// What the confirmation and the ends of a valley will take.
int Calibration::seeds_reserved() const {
  const Budget& b = study_.budget;
  if (!a_.knowledge) return b.confirmation_replicates + 2 * b.endpoint_replicates;
  const auto directions = combinations(study_, *a_.knowledge, best_);
  const bool ridge = std::any_of(directions.begin(), directions.end(),
                                 [](const Combination& c) { return !c.identifiable; });
  return b.confirmation_replicates + (ridge ? 2 * b.endpoint_replicates : 0);
}

// More points, away from those that have no number and from each other, when those so far are too
// few for a model. False when the budget has no more.
bool Calibration::explore_further() {
  if (study_.budget.runs == 0) return false;
  const int points =
      std::min(std::max(2, study_.budget.refine_points * point_multiplier_),
               (seeds_left() - study_.budget.confirmation_replicates) / replicates_per_point_);
  if (points < 1) {
    budget_used_ = true;
    return false;
  }
  using enum JobStatus;
  std::vector<OutcomeProbability> without;
  for (std::size_t e = 0; e < study_.experiments.size(); ++e)
    without.emplace_back(a_.points, e,
                         std::vector{arched, failed, crashed, timed_out, out_of_memory},
                         std::vector{finished});
  std::vector<VectorXd> taken;
  for (const Point& p : a_.points) taken.push_back(p.u);
  const auto d = static_cast<int>(study_.parameters.size());
  std::vector<Point> batch;
  constexpr std::uint64_t candidates = 1024;
  constexpr double reach = 0.15;  // unit cube
  for (int i = 0; i < points; ++i) {
    VectorXd best;
    double most = -1;
    for (std::uint64_t c = 0; c < candidates; ++c) {
      const VectorXd u = quasi_random_point(c, d);
      if (!allowed(study_.constraints, study_.parameters, u)) continue;
      double nearest = std::numeric_limits<double>::infinity(), score = 1;
      for (const VectorXd& t : taken) nearest = std::min(nearest, (u - t).squaredNorm());
      for (const OutcomeProbability& share : without) score *= std::pow(1 - share.at(u), 2);
      score *= 1 - std::exp(-0.5 * nearest / (reach * reach));
      if (score > most) {
        most = score;
        best = u;
      }
    }
    taken.push_back(best);
    int number = static_cast<int>(batch.size());
    for (const Point& p : a_.points) number += p.phase == "design, continued";
    batch.push_back(campaign_.point("design, continued", number,
                                    allowed_values(study_.constraints, study_.parameters, best),
                                    seed_range(study_.seed, replicates_per_point_)));
  }
  progress_.phase("exploring further");
  campaign_.run(batch);
  a_.points.insert(a_.points.end(), batch.begin(), batch.end());
  return true;
}

// Adds replicates where runs may be outliers, then marks the outliers among all.
void Calibration::check_outliers() {
  constexpr std::size_t points_at_most = 4;
  constexpr int seeds = 3;  // enough to find the outlier among them
  a_.outliers = mark_outliers(study_, a_.points);
  std::vector<Point> again;
  std::vector<std::size_t> where;
  int left =
      study_.budget.runs > 0 ? seeds_left() - seeds_reserved() : std::numeric_limits<int>::max();
  for (const std::size_t i : doubtful_points(study_, a_.points, points_at_most)) {
    const int more = seeds - static_cast<int>(a_.points[i].seeds.size());
    if (more > left) break;
    left -= more;
    where.push_back(i);
    again.push_back(a_.points[i]);
    std::uint64_t next = again.back().seeds.back();
    for (int k = 0; k < more; ++k) again.back().seeds.push_back(++next);
  }
  if (again.empty()) return;
  progress_.phase("repeating possible outliers");
  campaign_.run(again);
  for (std::size_t i = 0; i < where.size(); ++i) a_.points[where[i]] = again[i];
  a_.outliers = mark_outliers(study_, a_.points);
}

// False when the finished runs are too few for a model.
bool Calibration::fit() {
  check_outliers();
  a_.knowledge = fit_response_models(study_, a_.points);
  if (!a_.knowledge) {
    a_.verdict = StudyVerdict::too_few_runs;
    return false;
  }
  const NegativeLogPosterior misfit(study_, *a_.knowledge);
  best_ = misfit.best().x;
  a_.posterior = sample_posterior(study_, misfit);
  record_estimate(a_.rounds == 0 ? "design" : fmt::format("refinement {}", a_.rounds));
  report_estimate();
  judge_fit();
  return true;
}

// Of a resumed study, too: it fits after the same rounds again.
void Calibration::record_estimate(const std::string& after) {
  std::set<std::string> runs;
  for (const auto* points : {&a_.points, &numerics_})
    for (const Point& p : *points)
      for (const std::vector<std::string>& keys : p.keys) runs.insert(keys.begin(), keys.end());
  a_.estimate_history.push_back({after, static_cast<int>(runs.size()), a_.posterior->marginals});
}

// Whether all targets can be met together, and the range of each.
void Calibration::judge_fit() {
  const bool priors = prior_count(study_.priors, study_.parameters) > 0;
  a_.goodness = goodness_of_fit(study_, *a_.knowledge, best_, Priors::with);
  a_.without_priors.reset();
  if (priors) a_.without_priors = goodness_of_fit(study_, *a_.knowledge, best_, Priors::without);
  a_.reach.clear();
  const int d = static_cast<int>(study_.parameters.size());
  for (std::size_t k = 0; k < study_.targets.size(); ++k) {
    const Target& t = study_.targets[k];
    const ResponseModel& m = a_.knowledge->targets[k];
    ReachedRange r{m.lowest, m.highest, m.lowest <= t.value && t.value <= m.highest, false};
    const auto look = [&](const VectorXd& u) {
      if (!allowed(study_.constraints, study_.parameters, u)) return;
      const Prediction p = m.surrogate.best.predict(u);
      r.lowest = std::min(r.lowest, p.mean);
      r.highest = std::max(r.highest, p.mean);
      const double sd = std::hypot(t.uncertainty, std::sqrt(p.variance));
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

// Whether a point with a number for every target is so near that the model does not extrapolate.
bool Calibration::simulated_nearby(const VectorXd& u) const {
  constexpr double near = 0.03;  // of the range, root mean square over the parameters
  return std::any_of(a_.points.begin(), a_.points.end(), [&](const Point& p) {
    return (p.u - u).norm() <= near * std::sqrt(static_cast<double>(u.size())) &&
           std::all_of(study_.targets.begin(), study_.targets.end(),
                       [&](const Target& t) { return !p.finished(t.response).empty(); });
  });
}

// Reports the best region so far and the combinations that the data determine.
void Calibration::report_estimate() const {
  const std::vector<double> values = allowed_values(study_.constraints, study_.parameters, best_);
  std::vector<std::string> regions, determined;
  nlohmann::ordered_json j = {{"best", nlohmann::ordered_json::object()},
                              {"determined", nlohmann::ordered_json::array()}};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Parameter& p = study_.parameters[i];
    const Marginal& m = a_.posterior->marginals[i];
    regions.push_back(fmt::format("{} = {} ({} to {})", p.name, p.text(values[i]), p.text(m.low),
                                  p.text(m.high)));
    j["best"][p.name] = {{"value", values[i]}, {"low", m.low}, {"high", m.high}, {"unit", p.unit}};
  }
  for (const Combination& c : combinations(study_, *a_.knowledge, best_)) {
    if (!c.identifiable) continue;
    const std::string text = combination_text(study_, c);
    determined.push_back(fmt::format("{} = {:.3g} +- {:.2g}", text, c.value, c.sd));
    j["determined"].push_back({{"combination", text}, {"value", c.value}, {"uncertainty", c.sd}});
  }
  for (const Target& t : study_.targets)
    j["targets"].push_back({{"response", t.response.name}, {"value", t.value}});
  progress_.knowledge(
      fmt::format(
          "  best so far: {}\n  determined: {}", fmt::join(regions, ", "),
          determined.empty() ? "nothing yet" : fmt::format("{}", fmt::join(determined, "; "))),
      j.dump());
}

// Decides, and says why not: from the runs alone, so that a resumed study decides alike.
bool Calibration::worth_refining() {
  const Budget& b = study_.budget;
  const double gain = expected_narrowing(study_, *a_.knowledge, *a_.posterior, best_);
  const std::string could =
      gain < 1 ? fmt::format("could narrow what is determined by {:.0f} % at most", 100 * gain)
               : "may still determine more";
  const bool missed = !a_.goodness->acceptable();
  if (missed && simulated_nearby(a_.goodness->u)) {
    a_.stopped =
        "the parameters nearest to the targets were simulated, and do not meet them together";
    return false;
  }
  if (!missed && gain <= b.min_improvement) {
    a_.stopped = fmt::format(
        "further runs cannot help: knowing the responses perfectly {}; better measurements can",
        could);
    return false;
  }
  const bool bounded = b.runs > 0 && !b.rounds_stated;
  const bool none_left = bounded ? seeds_left() - seeds_reserved() < replicates_per_point_
                                 : a_.rounds >= b.refine_rounds;
  if (none_left || b.refine_points == 0) {
    budget_used_ = true;
    a_.stopped = fmt::format("the budget's runs are used; further ones {}", could);
    return false;
  }
  if (b.time > 0) {
    int runs = 0;
    for (const Point& p : a_.points) runs += static_cast<int>(p.seeds.size());
    // Runs with other numerics count in what was spent, but cost something else than those to come.
    const double spent = wall_of(a_.points) + wall_of(numerics_);
    const double each = wall_of(a_.points) / std::max(runs, 1);
    const int next = b.refine_points * b.replicates_per_point + b.confirmation_replicates +
                     2 * b.endpoint_replicates;
    if (spent + each * next > b.time) {
      a_.stopped = fmt::format("the budget's time is used; further runs {}", could);
      return false;
    }
  }
  return true;
}

void Calibration::refine() {
  std::vector<Point> batch;
  std::vector<VectorXd> taken;
  for (const Point& p : a_.points) taken.push_back(p.u);
  const std::string phase = fmt::format("refine {}", ++a_.rounds);
  int number = 0, points = study_.budget.refine_points * point_multiplier_;
  if (study_.budget.runs > 0 && !study_.budget.rounds_stated)
    points = std::min(points, (seeds_left() - seeds_reserved()) / replicates_per_point_);
  // Where the targets seem to be missed, the nearest parameters are simulated before that is said.
  const bool missed = !a_.goodness->acceptable();
  for (const VectorXd& u :
       refinement_points(study_, *a_.knowledge, *a_.posterior, missed ? a_.goodness->u : best_,
                         missed ? FirstPoint::answer : FirstPoint::answer_if_unsure, taken, points,
                         replicates_per_point_))
    batch.push_back(campaign_.point(phase, number++,
                                    allowed_values(study_.constraints, study_.parameters, u),
                                    seed_range(study_.seed, replicates_per_point_)));
  progress_.phase("splitting the equally good");
  campaign_.run(batch);
  a_.points.insert(a_.points.end(), batch.begin(), batch.end());
}

// Before its confirmation, whose runs must not have a say in it.
void Calibration::choose_answer() {
  if (!a_.goodness->acceptable()) best_ = a_.goodness->u;
  const std::vector<double> values = allowed_values(study_.constraints, study_.parameters, best_);
  best_ = to_unit(study_.parameters, values);
  a_.best = checked(a_.goodness->acceptable() ? "answer" : "nearest",
                    campaign_.point("confirm", 0, values, {}));
  for (const ResponseModel& m : a_.knowledge->targets)
    a_.cross_check.push_back(m.surrogate.other.predict(best_).mean);
  a_.combinations = combinations(study_, *a_.knowledge, best_);
  decide_whether_determined();
}

void Calibration::decide_whether_determined() {
  const bool all_identified = std::all_of(a_.combinations.begin(), a_.combinations.end(),
                                          [](const Combination& c) { return c.identifiable; });
  a_.verdict = all_identified ? StudyVerdict::calibrated : StudyVerdict::not_identifiable;
  if (all_identified) a_.ridge.clear();
  if (all_identified || !a_.ridge.empty()) return;
  const NegativeLogPosterior misfit(study_, *a_.knowledge);
  for (const RidgeMember& member : ridge(study_, misfit, *a_.posterior))
    a_.ridge.push_back(checked(fmt::format("member {}", a_.ridge.size() + 1),
                               campaign_.point("valley", 0, member.values, {})));
}

// Final models, from all runs including the confirmation runs. These are replicates at one point
// and determine the noise at the estimate.
void Calibration::describe_knowledge() {
  a_.knowledge = fit_response_models(study_, a_.points);
  const NegativeLogPosterior misfit(study_, *a_.knowledge);
  a_.posterior = sample_posterior(study_, misfit);
  record_estimate("confirmation");
  for (const ResponseModel& m : a_.knowledge->targets)
    a_.predictive.push_back(posterior_predictive(m, *a_.posterior));
  a_.combinations = combinations(study_, *a_.knowledge, best_);
  rms_over_posterior(*a_.posterior, study_, a_.combinations);
  decide_whether_determined();
  for (std::size_t k = 0; k < study_.targets.size(); ++k) {
    const Prediction p = a_.knowledge->targets[k].surrogate.best.predict(best_);
    a_.split.push_back({std::pow(study_.targets[k].uncertainty, 2), p.noise_variance,
                        p.variance - p.noise_variance});
  }
  a_.profiles = profile_likelihoods(study_, misfit, *a_.posterior);
  a_.advice = rank_measurements(study_, *a_.knowledge, *a_.posterior);
  a_.cut_short_share = a_.knowledge->cut_short_probability(best_);
  judge_fit();
  if (!a_.goodness->acceptable()) {
    const bool by_priors = a_.without_priors && a_.without_priors->acceptable();
    a_.verdict = by_priors ? StudyVerdict::prior_conflict : StudyVerdict::infeasible;
  } else if (!agrees(a_.best)) {
    a_.verdict = StudyVerdict::unconfirmed;
  }
  if (!a_.outliers.empty())
    a_.cautions.push_back(a_.outliers.size() == 1
                              ? "one outlier run was left out"
                              : fmt::format("{} outlier runs were left out", a_.outliers.size()));
  for (std::size_t k = 0; k < study_.targets.size(); ++k)
    if (const Observation& o = a_.best.observed[k];
        o.standard_error > agreement * study_.targets[k].uncertainty)
      a_.cautions.push_back(
          fmt::format("{} is confirmed to +- {:.2g} only, and was measured to +- {:.2g}",
                      o.response, o.standard_error, study_.targets[k].uncertainty));
  for (const ResponseModel& m : a_.knowledge->targets)
    if (!m.passes_cross_validation())
      a_.cautions.push_back(
          fmt::format("the model of {} does not explain its own runs", m.response.label));
}

void Calibration::confirm() {
  const Budget& b = study_.budget;
  int seeds = b.confirmation_replicates;
  // Runs that are left confirm: all, where no batch can use them, else as many again.
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
      campaign_.point("confirm", 0, a_.best.values, seed_range(first, seeds))};
  progress_.phase("confirming with fresh seeds");
  campaign_.run(batch);
  a_.points.push_back(batch[0]);
  a_.outliers = mark_outliers(study_, a_.points);
  observe(study_, &*a_.knowledge, a_.points.back(), a_.best);
}

void Calibration::check_valley_ends() {
  if (a_.ridge.empty() || study_.budget.endpoint_replicates == 0) return;
  std::vector<CheckedSet*> ends = {&a_.ridge.front(), &a_.ridge.back()};
  std::vector<Point> batch;
  for (std::size_t i = 0; i < ends.size(); ++i)
    batch.push_back(campaign_.point("valley end", static_cast<int>(i), ends[i]->values,
                                    seed_range(study_.seed + anchor_seeds + i * anchor_stride,
                                               study_.budget.endpoint_replicates)));
  progress_.phase("checking the ends of the valley");
  campaign_.run(batch);
  a_.points.insert(a_.points.end(), batch.begin(), batch.end());
  a_.outliers = mark_outliers(study_, a_.points);
  for (std::size_t i = 0; i < ends.size(); ++i)
    observe(study_, &*a_.knowledge, a_.points[a_.points.size() - ends.size() + i], *ends[i]);
}

CheckedSet Calibration::checked(const std::string& name, const Point& point) const {
  CheckedSet set;
  set.name = name;
  set.values = point.values;
  if (a_.knowledge)
    for (const ResponseModel& m : a_.knowledge->targets)
      set.predicted.push_back(m.surrogate.best.predict(point.u));
  if (!point.results.empty()) observe(study_, a_.knowledge ? &*a_.knowledge : nullptr, point, set);
  return set;
}

// All targets together, so that many of them do not make a disagreement by chance likelier.
bool Calibration::agrees(const CheckedSet& set) const {
  constexpr double significance = 0.05;
  double chi_square = 0;
  for (std::size_t k = 0; k < study_.targets.size(); ++k) {
    const Target& t = study_.targets[k];
    const Observation& o = set.observed[k];
    if (o.sample.count < 2) return false;
    chi_square +=
        std::pow((o.sample.mean - t.value) / std::hypot(t.uncertainty, o.standard_error), 2);
  }
  return chi_square_tail(chi_square, static_cast<double>(study_.targets.size())) >= significance;
}

// Shifts by each numerics check, against the runs at the middle.
void Calibration::compare_numerics() {
  const auto centre = std::find_if(a_.points.begin(), a_.points.end(),
                                   [](const Point& p) { return p.phase == "centre"; });
  const ResponseModels* knowledge = a_.knowledge ? &*a_.knowledge : nullptr;
  for (std::size_t i = 0; i < numerics_.size(); ++i) {
    NumericsOutcome outcome{study_.numerics[i].name, {}};
    const auto compare = [&](const ResponseId& response) {
      const Sample there = sample(numerics_[i].finished(response));
      const Sample here = sample(centre->finished(response));
      if (there.count == 0 || here.count == 0) return;
      outcome.shifts.push_back({response.label, centre->unit(response), there.mean - here.mean,
                                std::hypot(standard_error(knowledge, response, centre->u, there),
                                           standard_error(knowledge, response, centre->u, here))});
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
  const Goodness& g = *a_.goodness;
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

CalibrationResult Calibration::finish() {
  // Now that the noise is known and there is a fit to ask.
  for (const CompareSet& set : study_.compare) {
    Point point = campaign_.point(compare_phase + set.name, 0, set.values, {});
    for (const Point& p : a_.points)
      if (p.phase == point.phase) point = p;
    a_.compare.push_back(checked(set.name, point));
    if (a_.posterior && point.u.minCoeff() >= 0 && point.u.maxCoeff() <= 1)
      a_.compare.back().hpd_level =
          a_.posterior->hpd_level(NegativeLogPosterior(study_, *a_.knowledge).cost(point.u));
  }
  compare_numerics();
  if (a_.knowledge)
    for (const auto* models : {&a_.knowledge->targets, &a_.knowledge->observed})
      for (const ResponseModel& m : *models) {
        const auto f = [&](const VectorXd& u) { return m.surrogate.best.predict(u).mean; };
        const int d = static_cast<int>(study_.parameters.size());
        Sensitivity s{m.response.label, sobol_indices(f, d, sobol_samples), 0};
        // The other kind of model is as good a witness of what the response depends on.
        const SobolIndices other = sobol_indices(
            [&](const VectorXd& u) { return m.surrogate.other.predict(u).mean; }, d, sobol_samples);
        const auto widen = [](Eigen::MatrixX2d& interval, const VectorXd& estimate) {
          interval.col(0) = interval.col(0).cwiseMin(estimate);
          interval.col(1) = interval.col(1).cwiseMax(estimate);
        };
        widen(s.indices.first_interval, other.first);
        widen(s.indices.total_interval, other.total);
        s.noise_share = std::pow(m.noise.at(f(VectorXd::Constant(d, 0.5))), 2) / s.indices.variance;
        a_.sensitivity.push_back(s);
      }
  account_for_budget();
  switch (a_.verdict) {
    case StudyVerdict::calibrated:
      a_.headline = fmt::format("calibrated: {}", parameter_text(study_, a_.best.values));
      break;
    case StudyVerdict::not_identifiable:
      a_.headline = fmt::format(
          "the targets are met along a ridge of equally good parameters; one member: {}",
          parameter_text(study_, a_.best.values));
      break;
    case StudyVerdict::unconfirmed:
      a_.headline = fmt::format(
          "not confirmed: fresh runs at {} {}", parameter_text(study_, a_.best.values),
          a_.best.cut_short > 0 ? "were cut short by a limit" : "do not meet the targets");
      break;
    case StudyVerdict::infeasible:
      a_.headline = misfit_text();
      break;
    case StudyVerdict::prior_conflict:
      a_.headline = fmt::format(
          "the priors conflict with the targets: together chi-square {:.1f} on {:.1f} degrees of "
          "freedom (probability {:.2g}), the targets alone {:.1f} on {:.1f}; nearest by both: {}",
          a_.goodness->chi_square, a_.goodness->freedom, a_.goodness->probability,
          a_.without_priors->chi_square, a_.without_priors->freedom,
          parameter_text(study_, a_.best.values));
      break;
    case StudyVerdict::too_few_runs:
      a_.headline = "too few runs finished to fit anything" + failure_text();
      break;
    case StudyVerdict::direct_search_only:
    case StudyVerdict::interrupted:
      break;
  }
  for (const std::string& caution : a_.cautions) a_.headline += "; " + caution;
  return std::move(a_);
}

}  // namespace firn
