#include "calibrate/direct_search.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "calibrate/calibration.h"

namespace firn {
namespace {

using Eigen::VectorXd;

// Root mean square of (simulated - target) / uncertainty; not a number where a target has no value.
double distance(const Study& study, const Point& point) {
  double sum = 0;
  for (const Target& t : study.targets) {
    const Sample s = sample(point.finished(t.response));
    if (s.count == 0) return std::numeric_limits<double>::quiet_NaN();
    sum += std::pow((s.mean - t.value) / t.sd(), 2);
  }
  return std::sqrt(sum / static_cast<double>(study.targets.size()));
}

}  // namespace

CalibrationResult direct_search(const Study& study, StudyRuns& study_runs,
                                BatchProgress& progress) {
  CalibrationResult a;
  a.verdict = StudyVerdict::direct_search_only;
  std::vector<Point> compared;
  for (const CompareSet& set : study.compare)
    if (study.budget.compare_replicates > 0)
      compared.push_back(study_runs.point(kComparePhase + set.name,
                                          static_cast<int>(compared.size()), set.values,
                                          seed_list(study.seed, study.budget.compare_replicates)));
  study_runs.run(compared);

  progress.phase(fmt::format("direct search ({})", to_string(study.direct)));
  const auto evaluate = [&](const VectorXd& u) {
    std::vector<Point> one = {study_runs.point(
        "direct", static_cast<int>(a.points.size()), rounded_values(study.parameters, u),
        seed_list(study.seed, study.budget.replicates_per_point))};
    study_runs.run(one);
    a.points.push_back(one.front());
    return distance(study, one.front());
  };
  const auto d = static_cast<Eigen::Index>(study.parameters.size());
  const Minimum best = search_directly(evaluate, VectorXd::Zero(d), VectorXd::Ones(d), study.direct,
                                       study.direct_evaluations, study.seed);
  for (const Point& p : compared) {
    CheckedSet set;
    set.name = study.compare[static_cast<std::size_t>(p.number)].name;
    set.values = p.values;
    observe(study, nullptr, p, set);
    a.compare.push_back(set);
  }
  if (best.x.size() == 0) {
    a.verdict = StudyVerdict::too_few_runs;
    a.headline = "no evaluation of the search finished";
    return a;
  }
  a.best.name = "best";
  a.best.values = rounded_values(study.parameters, best.x);
  std::vector<Point> fresh = {study_runs.point(
      "confirm", 0, a.best.values,
      seed_list(study.seed + confirm_seeds, study.budget.confirmation_replicates))};
  progress.phase("confirming with fresh seeds");
  study_runs.run(fresh);
  observe(study, nullptr, fresh.front(), a.best);
  a.direct = {best.evaluations, best.value, distance(study, fresh.front())};
  a.headline = fmt::format(
      "best of {} evaluations by {}: {}; {:.2g} standard deviations from the targets by fresh "
      "seeds, {:.2g} as the search saw it",
      best.evaluations, to_string(study.direct), parameter_text(study, a.best.values),
      a.direct->confirmed, a.direct->best_observed);
  return a;
}

}  // namespace firn
