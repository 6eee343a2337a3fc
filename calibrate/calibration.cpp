#include "calibrate/calibration.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "calibrate/design.h"

namespace firn {
namespace {

using Eigen::VectorXd;

// Seeds of the confirmation and of the anchors start this far above the study's: never used before.
constexpr std::uint64_t confirm_seeds = 1000, anchor_seeds = 2000, anchor_stride = 500;
// Phases of the runs that are asked for by name.
const std::string compare_phase = "compare: ";
// How many standard deviations still count as agreement.
constexpr double agreement = 2;

std::vector<std::uint64_t> seeds(std::uint64_t first, int count) {
  std::vector<std::uint64_t> s;
  for (int i = 0; i < count; ++i) s.push_back(first + static_cast<std::uint64_t>(i));
  return s;
}

}  // namespace

// The named sets, the middle of the ranges for the noise, and a design that fills them. Points
// share their seeds: the same packing where the parameters allow it.
void Calibration::explore() {
  const int d = static_cast<int>(study_.parameters.size());
  std::vector<Point>& points = a_.points;
  for (std::size_t i = 0; i < study_.compare.size() && study_.budget.compare_runs > 0; ++i)
    points.push_back(campaign_.point(compare_phase + study_.compare[i].name, static_cast<int>(i),
                                     study_.compare[i].values,
                                     seeds(study_.seed, study_.budget.compare_runs)));
  const auto add = [&](const char* phase, int number, const VectorXd& u, int runs) {
    points.push_back(campaign_.point(phase, number, tidy_values(study_.parameters, u),
                                     seeds(study_.seed, runs)));
  };
  add("centre", 0, VectorXd::Constant(d, 0.5), study_.budget.centre_runs);
  std::vector<VectorXd> taken;
  for (const Point& p : points) taken.push_back(p.u);
  int number = 0;
  for (const VectorXd& u :
       maximin_latin_hypercube(study_.budget.design_points, d, study_.seed, taken))
    add("design", number++, u, study_.budget.runs_per_point);
  progress_.phase("exploring the ranges");
  campaign_.run(points);
}

// True when the targets are within reach of the ranges as far as is known.
bool Calibration::fit() {
  a_.knowledge = learn(study_, a_.points);
  if (!a_.knowledge) {
    a_.verdict = StudyVerdict::too_few_runs;
    return false;
  }
  const Misfit misfit(study_, *a_.knowledge);
  best_ = misfit.best().x;
  a_.posterior = sample_posterior(study_, misfit);
  a_.reach.clear();
  const bool within = misfit.z(best_).cwiseAbs().maxCoeff() <= agreement;
  const int d = static_cast<int>(study_.parameters.size());
  for (std::size_t k = 0; k < study_.targets.size(); ++k) {
    const Target& t = study_.targets[k];
    const ResponseModel& m = a_.knowledge->targets[k];
    ReachedRange r{m.lowest, m.highest, m.lowest <= t.value && t.value <= m.highest, false};
    for (std::uint64_t i = 0; i < 4096; ++i) {
      const Prediction p = m.surrogate.best.predict(quasi_random_point(i, d));
      r.lowest = std::min(r.lowest, p.mean);
      r.highest = std::max(r.highest, p.mean);
      const double sd = std::hypot(t.uncertainty, std::sqrt(p.variance));
      r.reachable = r.reachable || std::abs(p.mean - t.value) <= agreement * sd;
    }
    a_.reach.push_back(r);
  }
  if (within) return true;
  a_.verdict = StudyVerdict::out_of_reach;
  a_.best =
      checked("nearest", campaign_.point("nearest", 0, tidy_values(study_.parameters, best_), {}));
  return false;
}

void Calibration::refine(int round) {
  std::vector<Point> batch;
  std::vector<VectorXd> taken;
  for (const Point& p : a_.points) taken.push_back(p.u);
  int number = 0;
  for (const VectorXd& u :
       splitting_points(study_, *a_.knowledge, *a_.posterior, taken, study_.budget.refine_points))
    batch.push_back(campaign_.point(fmt::format("refine {}", round + 1), number++,
                                    tidy_values(study_.parameters, u),
                                    seeds(study_.seed, study_.budget.runs_per_point)));
  progress_.phase("splitting the equally good");
  campaign_.run(batch);
  a_.points.insert(a_.points.end(), batch.begin(), batch.end());
}

void Calibration::describe_fit() {
  const Misfit misfit(study_, *a_.knowledge);
  const std::vector<double> values = tidy_values(study_.parameters, best_);
  best_ = to_unit(study_.parameters, values);
  a_.best = checked("answer", campaign_.point("confirm", 0, values, {}));
  for (std::size_t k = 0; k < study_.targets.size(); ++k) {
    const ResponseModel& m = a_.knowledge->targets[k];
    const Prediction& p = a_.best.predicted[k];
    a_.cross_check.push_back(m.surrogate.other.predict(best_).mean);
    a_.split.push_back({std::pow(study_.targets[k].uncertainty, 2), p.noise_variance,
                        p.variance - p.noise_variance});
  }
  a_.combinations = combinations(study_, *a_.knowledge, best_);
  const bool all_identified = std::all_of(a_.combinations.begin(), a_.combinations.end(),
                                          [](const Combination& c) { return c.identified; });
  a_.verdict = all_identified ? StudyVerdict::calibrated : StudyVerdict::undetermined;
  if (all_identified) return;
  for (const ValleyMember& member : valley(study_, misfit, *a_.posterior))
    a_.valley.push_back(checked(fmt::format("member {}", a_.valley.size() + 1),
                                campaign_.point("valley", 0, member.values, {})));
}

void Calibration::confirm() {
  std::vector<Point> batch = {
      campaign_.point("confirm", 0, a_.best.values,
                      seeds(study_.seed + confirm_seeds, study_.budget.confirm_runs))};
  progress_.phase("confirming with fresh seeds");
  campaign_.run(batch);
  observe(batch[0], a_.best);
  if (!agrees(a_.best)) a_.verdict = StudyVerdict::unconfirmed;
}

void Calibration::check_valley_ends() {
  if (a_.valley.empty() || study_.budget.anchor_runs == 0) return;
  std::vector<CheckedSet*> ends = {&a_.valley.front(), &a_.valley.back()};
  std::vector<Point> batch;
  for (std::size_t i = 0; i < ends.size(); ++i)
    batch.push_back(campaign_.point(
        "valley end", static_cast<int>(i), ends[i]->values,
        seeds(study_.seed + anchor_seeds + i * anchor_stride, study_.budget.anchor_runs)));
  progress_.phase("checking the ends of the valley");
  campaign_.run(batch);
  for (std::size_t i = 0; i < ends.size(); ++i) observe(batch[i], *ends[i]);
}

CheckedSet Calibration::checked(const std::string& name, const Point& point) const {
  CheckedSet set;
  set.name = name;
  set.values = point.values;
  if (a_.knowledge)
    for (const ResponseModel& m : a_.knowledge->targets)
      set.predicted.push_back(m.surrogate.best.predict(point.u));
  if (!point.results.empty()) observe(point, set);
  return set;
}

void Calibration::observe(const Point& point, CheckedSet& set) const {
  set.finished = point.count(JobStatus::finished);
  set.arched = point.count(JobStatus::arched);
  set.failed = point.count(JobStatus::failed);
  const auto add = [&](const std::string& response, const std::string& unit) {
    const Sample s = sample(point.finished(response));
    set.observed.push_back({response, unit, s, standard_error(response, s)});
  };
  for (const Target& t : study_.targets) add(t.response, t.unit);
  for (const std::string& name : study_.observed) {
    std::string unit;
    for (const JobResult& result : point.results)
      for (const Response& r : result.responses)
        if (r.name == name) unit = r.unit;
    add(name, unit);
  }
}

// The pooled noise and this sample's own spread, each with its degrees of freedom.
double Calibration::standard_error(const std::string& response, const Sample& s) const {
  if (s.count == 0) return std::numeric_limits<double>::quiet_NaN();
  double squares = s.sum_of_squares, freedom = s.count - 1;
  if (a_.knowledge)
    for (const auto* models : {&a_.knowledge->targets, &a_.knowledge->observed})
      for (const ResponseModel& m : *models)
        if (m.name == response) {
          squares += m.noise.degrees_of_freedom * std::pow(m.noise.at(s.mean), 2);
          freedom += m.noise.degrees_of_freedom;
        }
  return std::sqrt(squares / freedom / s.count);
}

bool Calibration::agrees(const CheckedSet& set) const {
  if (set.finished < 2) return false;
  for (std::size_t k = 0; k < study_.targets.size(); ++k) {
    const Target& t = study_.targets[k];
    const Observation& o = set.observed[k];
    if (!(std::abs(o.sample.mean - t.value) <=
          agreement * std::hypot(t.uncertainty, o.standard_error)))
      return false;
  }
  return true;
}

std::string Calibration::parameter_text(const std::vector<double>& values) const {
  std::vector<std::string> parts;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Parameter& p = study_.parameters[i];
    parts.push_back(
        fmt::format("{} = {:.4g}{}{}", p.name, values[i], p.unit.empty() ? "" : " ", p.unit));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::string Calibration::range_text() const {
  std::vector<std::string> missed;
  for (std::size_t k = 0; k < study_.targets.size(); ++k)
    if (const ReachedRange& r = a_.reach[k]; !r.reachable)
      missed.push_back(fmt::format("{} = {:.4g} {} (the ranges give {:.4g} to {:.4g})",
                                   study_.targets[k].response, study_.targets[k].value,
                                   study_.targets[k].unit, r.lowest, r.highest));
  return missed.empty()
             ? "no parameters within the ranges meet all targets at once"
             : fmt::format("target out of reach of the ranges: {}", fmt::join(missed, "; "));
}

Answer Calibration::finish() {
  // Now that the noise is known and there is a fit to ask.
  for (const Point& p : a_.points)
    if (p.phase.starts_with(compare_phase))
      a_.compare.push_back(checked(study_.compare[static_cast<std::size_t>(p.number)].name, p));
  switch (a_.verdict) {
    case StudyVerdict::calibrated:
      a_.headline = fmt::format("calibrated: {}", parameter_text(a_.best.values));
      break;
    case StudyVerdict::undetermined:
      a_.headline = fmt::format(
          "the targets are met along a valley of equally good parameters; one member: {}",
          parameter_text(a_.best.values));
      break;
    case StudyVerdict::unconfirmed:
      a_.headline = fmt::format("not confirmed: fresh runs at {} do not meet the targets",
                                parameter_text(a_.best.values));
      break;
    case StudyVerdict::out_of_reach:
      a_.headline = range_text();
      break;
    case StudyVerdict::too_few_runs:
      a_.headline = "too few runs finished to fit anything";
      break;
    case StudyVerdict::interrupted:
      break;
  }
  return std::move(a_);
}

}  // namespace firn
