#include "calibrate/calibration.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "calibrate/inference/repeats.h"

namespace firn {
namespace {

using Eigen::VectorXd;

double wall_of(const std::vector<Point>& points) {
  double sum = 0;
  for (const Point& p : points) sum += p.wall();
  return sum;
}

}  // namespace

std::string parameter_text(const Study& study, const std::vector<double>& values) {
  std::vector<std::string> parts;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Parameter& p = study.parameters[i];
    parts.push_back(
        fmt::format("{} = {}{}{}", p.name, p.text(values[i]), p.unit.empty() ? "" : " ", p.unit));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

// Carries out the runs of points, and finds the scores of their curves.
void Calibration::run(std::vector<Point>& points) {
  study_runs_.run(points);
  for (std::size_t i = 0; i < a_.curves.size(); ++i)
    for (Point& p : points) add_scores(study_.curves[i], a_.curves[i], p);
}

// Computes the principal components of the simulated curves and adds their scores as targets. False
// where too few runs have a curve.
bool Calibration::define_scores() {
  for (const CurveTarget& c : study_.curves) {
    const auto basis = curve_basis(c, a_.points);
    if (!basis) return false;
    a_.curves.push_back(*basis);
    for (Target& t : score_targets(c, *basis)) study_.targets.push_back(std::move(t));
    for (auto* points : {&a_.points, &numerics_})
      for (Point& p : *points) add_scores(c, *basis, p);
  }
  return true;
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

// Number of runs for the confirmation and the ends of a ridge.
int Calibration::seeds_reserved() const {
  const Budget& b = study_.budget;
  if (!a_.models) return b.confirmation_replicates + 2 * b.endpoint_replicates;
  const auto directions = combinations(study_, *a_.models, best_);
  const bool ridge = std::any_of(directions.begin(), directions.end(),
                                 [](const Combination& c) { return !c.identifiable; });
  return b.confirmation_replicates + (ridge ? 2 * b.endpoint_replicates : 0);
}

// Adds replicates where runs may be outliers, then marks the outliers among all.
void Calibration::check_outliers() {
  constexpr std::size_t points_at_most = 4;
  constexpr int seeds = 3;  // enough to find the outlier among them
  a_.outliers = mark_outliers(study_, a_.points);
  std::vector<std::size_t> where;
  std::vector<int> more;
  int left =
      study_.budget.runs > 0 ? seeds_left() - seeds_reserved() : std::numeric_limits<int>::max();
  for (const std::size_t i : outlier_candidates(study_, a_.points, points_at_most)) {
    const int missing = seeds - static_cast<int>(a_.points[i].seeds.size());
    if (missing > left) break;
    left -= missing;
    where.push_back(i);
    more.push_back(missing);
  }
  if (where.empty()) return;
  run_more_seeds("repeating possible outliers", where, more);
  a_.outliers = mark_outliers(study_, a_.points);
}

// Unused seeds at points that have some.
void Calibration::run_more_seeds(const std::string& phase, const std::vector<std::size_t>& points,
                                 const std::vector<int>& seeds) {
  std::vector<Point> again;
  for (std::size_t i = 0; i < points.size(); ++i) {
    again.push_back(a_.points[points[i]]);
    for (const std::uint64_t seed : unused_seeds(seeds[i])) again.back().seeds.push_back(seed);
  }
  progress_.phase(phase);
  run(again);
  for (std::size_t i = 0; i < points.size(); ++i) a_.points[points[i]] = again[i];
}

// Where points with one run scatter by more than seeds do at the middle of the ranges, second runs
// decide once whether that is noise. False when there is nothing to repeat.
bool Calibration::repeat_points() {
  constexpr int points_at_most = 5;
  if (repeated_ || replicates_per_point_ != 1 || study_.budget.replicates_per_point < 2 ||
      !scatter_exceeds_noise(study_, *a_.models))
    return false;
  repeated_ = true;
  const int most = std::min(points_at_most, seeds_left() - seeds_reserved());
  const std::vector<std::size_t> where =
      points_to_repeat(study_, *a_.models, a_.points, static_cast<std::size_t>(std::max(0, most)));
  if (where.empty()) return false;
  run_more_seeds("repeating points", where, std::vector<int>(where.size(), 1));
  return true;
}

// False when the finished runs are too few for a model.
bool Calibration::fit() {
  check_outliers();
  a_.models = fit_response_models(study_, a_.points);
  if (!a_.models) {
    a_.verdict = StudyVerdict::too_few_runs;
    return false;
  }
  const NegativeLogPosterior misfit(study_, *a_.models);
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

// Whether a point of high fidelity with a number for every target is so near that the model does
// not extrapolate.
bool Calibration::has_run_near(const VectorXd& u) const {
  constexpr double near = 0.03;  // of the range, root mean square over the parameters
  return std::any_of(a_.points.begin(), a_.points.end(), [&](const Point& p) {
    return (p.u - u).norm() <= near * std::sqrt(static_cast<double>(u.size())) &&
           std::all_of(study_.targets.begin(), study_.targets.end(), [&](const Target& t) {
             return !p.is_low_fidelity(t.response.experiment) && !p.finished(t.response).empty();
           });
  });
}

// Whether the bias of the low fidelity is the larger part of what the model of a target is
// uncertain by at the estimate: runs of low fidelity cannot narrow it then.
bool Calibration::is_bias_dominant() const {
  constexpr double larger_part = 0.5;  // of the variance
  return std::any_of(a_.models->targets.begin(), a_.models->targets.end(),
                     [&](const ResponseModel& m) {
                       const double bias = m.surrogate.best.fidelity_bias(best_).sd;
                       return bias * bias > larger_part * m.surrogate.best.predict(best_).variance;
                     });
}

// Reports the best region so far and the combinations that the data determine.
void Calibration::report_estimate() const {
  const std::vector<double> values = allowed_values(study_.constraints, study_.parameters, best_);
  std::vector<std::string> regions, determined;
  if (study_.chosen) regions.push_back(study_.chosen_text());
  BatchKnowledge known;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Parameter& p = study_.parameters[i];
    const Marginal& m = a_.posterior->marginals[i];
    regions.push_back(fmt::format("{} = {} ({} to {})", p.name, p.text(values[i]), p.text(m.low),
                                  p.text(m.high)));
    known.best.push_back({p.name, {values[i], m.low, m.high, p.unit}});
  }
  for (const Combination& c : combinations(study_, *a_.models, best_)) {
    if (!c.identifiable) continue;
    known.determined.push_back({combination_text(study_, c), c.value, c.sd});
    determined.push_back(known.determined.back().text());
  }
  for (const Target& t : study_.targets) known.targets.push_back({t.response.name, t.value});
  progress_.knowledge(
      fmt::format(
          "  best so far: {}\n  determined: {}", fmt::join(regions, ", "),
          determined.empty() ? "nothing yet" : fmt::format("{}", fmt::join(determined, "; "))),
      known);
}

// Sets the reason if it returns false. Depends on the runs only, so that a resumed study refines in
// the same way.
bool Calibration::should_refine() {
  const Budget& b = study_.budget;
  const double gain = expected_narrowing(study_, *a_.models, *a_.posterior, best_);
  const std::string could =
      gain < 1 ? fmt::format("could narrow what is determined by {:.0f} % at most", 100 * gain)
               : "may still determine more";
  const bool missed = !a_.goodness->acceptable();
  if (missed && has_run_near(a_.goodness->u)) {
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
  if (repeat_points()) {
    ++a_.rounds;
    return;
  }
  // The noise was found to be larger than at the middle of the ranges.
  if (repeated_ && noise_exceeds_measurement(study_, *a_.models)) {
    replicates_per_point_ = study_.budget.replicates_per_point;
    point_multiplier_ = 1;
  }
  std::vector<Point> batch;
  std::vector<VectorXd> taken;
  for (const Point& p : a_.points) taken.push_back(p.u);
  const std::string phase = fmt::format("refine {}", ++a_.rounds);
  int number = 0, points = study_.budget.refine_points * point_multiplier_;
  if (study_.budget.runs > 0 && !study_.budget.rounds_stated)
    points = std::min(points, (seeds_left() - seeds_reserved()) / replicates_per_point_);
  // Where the targets seem to be missed, the nearest parameters are simulated before that is said.
  const bool missed = !a_.goodness->acceptable();
  const bool low = study_.low_fidelity && !missed && !is_bias_dominant();
  for (const VectorXd& u :
       refinement_points(study_, *a_.models, *a_.posterior, missed ? a_.goodness->u : best_,
                         missed ? FirstPoint::estimate : FirstPoint::estimate_if_uncertain, taken,
                         points, replicates_per_point_, low)) {
    batch.push_back(study_runs_.point(phase, number++,
                                      allowed_values(study_.constraints, study_.parameters, u),
                                      unused_seeds(replicates_per_point_)));
    if (low) batch.back() = study_runs_.in_low_fidelity(batch.back());
  }
  progress_.phase("splitting the equally good");
  run(batch);
  a_.points.insert(a_.points.end(), batch.begin(), batch.end());
}

}  // namespace firn
