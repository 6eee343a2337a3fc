// The points of a calibration before its models: the initial design, and more points where too many
// of its runs have no number.
#include <algorithm>
#include <cmath>
#include <limits>

#include "calibrate/calibration.h"
#include "calibrate/numerics/experimental_design.h"

namespace firn {
namespace {

using Eigen::VectorXd;

// Where runs are likely to give a number, away from the places that are taken.
VectorXd promising_place(const Study& study, const std::vector<OutcomeProbability>& without,
                         const std::vector<VectorXd>& taken) {
  constexpr std::uint64_t candidates = 1024;
  constexpr double reach = 0.15;  // unit cube
  const auto d = static_cast<int>(study.parameters.size());
  VectorXd best;
  double most = -1;
  for (std::uint64_t c = 0; c < candidates; ++c) {
    const VectorXd u = quasi_random_point(c, d);
    if (!allowed(study.constraints, study.parameters, u)) continue;
    double nearest = std::numeric_limits<double>::infinity(), score = 1;
    for (const VectorXd& t : taken) nearest = std::min(nearest, (u - t).squaredNorm());
    for (const OutcomeProbability& share : without) score *= std::pow(1 - share.at(u), 2);
    score *= 1 - std::exp(-0.5 * nearest / (reach * reach));
    if (score > most) {
      most = score;
      best = u;
    }
  }
  return best;
}

}  // namespace

// Seeds that no point has used. If the scatter depends on the seed alone, points with equal seeds
// have equal errors, which the fit does not average out.
std::vector<std::uint64_t> Calibration::unused_seeds(int count) {
  std::uint64_t first = next_seed_.value_or(study_.seed + design_seeds);
  if (!next_seed_)
    for (const Point& p : a_.points)  // of other studies, too
      for (const std::uint64_t seed : p.seeds) first = std::max(first, seed + 1);
  next_seed_ = first + static_cast<std::uint64_t>(count);
  return seed_list(first, count);
}

// Runs the parameter sets of [[compare]], and the middle of the ranges with the case's numerics and
// with those of [[numerics]]. The latter use equal seeds, so that they differ by the numerics only.
void Calibration::run_initial_design() {
  const Budget& b = study_.budget;
  const std::vector<double> middle =
      allowed_values(study_.constraints, study_.parameters, study_.constraints.middle);
  std::vector<Point> points;
  for (std::size_t i = 0; i < study_.compare.size() && b.compare_replicates > 0; ++i)
    points.push_back(study_runs_.point(kComparePhase + study_.compare[i].name, static_cast<int>(i),
                                       study_.compare[i].values,
                                       seed_list(study_.seed, b.compare_replicates)));
  const Point center =
      study_runs_.point("center", 0, middle, seed_list(study_.seed, b.center_replicates));
  if (study_.low_fidelity) {
    points.push_back(study_runs_.in_low_fidelity(center));
    points.back().only = study_.low_fidelity->only;
  }
  points.push_back(center);
  for (const NumericsCheck& check : study_.numerics) {
    numerics_.push_back(study_runs_.point("numerics: " + check.name,
                                          static_cast<int>(numerics_.size()), middle,
                                          seed_list(study_.seed, b.numerics_replicates)));
    numerics_.back().set = check.set;
    numerics_.back().only = check.only;
  }
  // Reused runs of other studies come first. A run counts at one point only.
  std::vector<Point> reused = reused_points();
  for (Point& p : reused)
    for (const Point& asked : points)
      if (p.values == asked.values && asked.low_fidelity.empty())
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
  run(points);
  numerics_.assign(points.begin() + asked, points.end());
  points.erase(points.begin() + asked, points.end());
  a_.points = std::move(points);
  for (const Point& p : reused) a_.reused += static_cast<int>(p.seeds.size());
  a_.reused *= static_cast<int>(study_.experiments.size());
  space_filling_design();
}

std::vector<Point> Calibration::reused_points() {
  const Budget& b = study_.budget;
  if (!b.reuse || b.runs == 0 || b.rounds_stated) return {};
  const int most = b.runs - b.center_replicates - b.confirmation_replicates;
  return study_runs_.reusable(most * static_cast<int>(study_.experiments.size()));
}

// A design that fills the ranges.
void Calibration::space_filling_design() {
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
    design.push_back(study_runs_.point("design", static_cast<int>(design.size()),
                                       allowed_values(study_.constraints, study_.parameters, u),
                                       unused_seeds(replicates_per_point_)));
  if (study_.low_fidelity) design = in_both_forms(std::move(design));
  progress_.phase("exploring the ranges");
  run(design);
  a_.points.insert(a_.points.end(), design.begin(), design.end());
}

// The points of a design in low fidelity, and a few that lie far apart in both forms. What the low
// fidelity does not change is simulated once.
std::vector<Point> Calibration::in_both_forms(std::vector<Point> design) const {
  const auto pairs = std::min(static_cast<std::size_t>(study_.low_fidelity->pairs), design.size());
  std::vector<VectorXd> taken = {a_.points.back().u};  // the center is simulated in both
  std::vector<Point> all;
  all.reserve(design.size() + pairs);
  for (const Point& p : design) all.push_back(study_runs_.in_low_fidelity(p));
  for (std::size_t i = 0; i < pairs; ++i) {
    const auto distance = [&](const Point& p) {
      double least = std::numeric_limits<double>::infinity();
      for (const VectorXd& u : taken) least = std::min(least, (p.u - u).norm());
      return least;
    };
    const auto farthest =
        std::max_element(design.begin(), design.end(),
                         [&](const Point& a, const Point& b) { return distance(a) < distance(b); });
    taken.push_back(farthest->u);
    all.push_back(*farthest);
    all.back().only = study_.low_fidelity->only;
  }
  return all;
}

// Whether seeds at the middle differ by less than what each target is uncertain by.
bool Calibration::noise_is_negligible() const {
  const Point& center = a_.points.back();
  if (!study_.curves.empty()) return false;  // their components are not known yet
  return std::all_of(study_.targets.begin(), study_.targets.end(), [&](const Target& t) {
    const Sample s = sample(center.finished(t.response));
    return s.count >= 2 && s.sd() < t.sd();
  });
}

// More points, away from those that have no number and from each other, when those so far are too
// few for a model. False when the budget has no more.
bool Calibration::extend_design() {
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
  std::vector<Point> batch;
  for (int i = 0; i < points; ++i) {
    const VectorXd best = promising_place(study_, without, taken);
    taken.push_back(best);
    int number = static_cast<int>(batch.size());
    for (const Point& p : a_.points) number += p.phase.ends_with("design, continued");
    batch.push_back(study_runs_.point("design, continued", number,
                                      allowed_values(study_.constraints, study_.parameters, best),
                                      unused_seeds(replicates_per_point_)));
    if (study_.low_fidelity) batch.back() = study_runs_.in_low_fidelity(batch.back());
  }
  progress_.phase("exploring further");
  run(batch);
  a_.points.insert(a_.points.end(), batch.begin(), batch.end());
  return true;
}

}  // namespace firn
