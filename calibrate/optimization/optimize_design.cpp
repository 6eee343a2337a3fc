#include "calibrate/optimization/optimize_design.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "calibrate/numerics/experimental_design.h"
#include "calibrate/numerics/optimize.h"
#include "calibrate/output/calibration_result.h"
#include "experiments/analysis/sample_statistics.h"
#include "experiments/system/interruption.h"
#include "experiments/system/output_file.h"
#include "experiments/text/number_text.h"

namespace firn {
namespace {

using Eigen::VectorXd;

namespace fs = std::filesystem;

// Offset of the confirmation seeds from the seed of the search, which does not use them.
constexpr std::uint64_t confirmation_seeds = 1000;
constexpr std::uint64_t candidates = 4096;
constexpr double likely = 0.5;  // probability that the limits are kept
// Between the designs of one round, of the range of at least one parameter. A model with
// independent departures does not become surer near a design that it believes.
constexpr double least_distance = 0.1;

double normal_density(double z) { return std::exp(-0.5 * z * z) / std::sqrt(2 * M_PI); }
double normal_probability(double z) { return 0.5 * std::erfc(-z / std::sqrt(2.0)); }

std::vector<EventCount> counts_of(const OptimizationStudy& o, const EventLimit& limit,
                                  const std::vector<Point>& points) {
  std::vector<EventCount> counts;
  for (const Point& p : points) {
    EventCount& c = counts.emplace_back(EventCount{p.u});
    for (std::size_t s = 0; s < p.seeds.size(); ++s)
      if (const auto value = p.value(o.study.observed[limit.response].response, s)) {
        ++c.runs;
        c.events += limit.happens(*value) ? 1 : 0;
      }
  }
  return counts;
}

// The place of the largest value of `f` among quasi-random ones and `more`, improved by a local
// search. Values that are not finite are no candidates. Nothing without a finite value.
std::optional<VectorXd> maximum(const std::function<double(const VectorXd&)>& f, int dimensions,
                                const std::vector<VectorXd>& more) {
  constexpr double first_step = 0.05;
  constexpr int evaluations = 200;
  std::optional<VectorXd> best;
  double largest = -std::numeric_limits<double>::infinity();
  const auto consider = [&](const VectorXd& u) {
    const double value = f(u);
    if (!std::isfinite(value) || value <= largest) return;
    largest = value;
    best = u;
  };
  for (std::uint64_t i = 0; i < candidates; ++i) consider(quasi_random_point(i, dimensions));
  for (const VectorXd& u : more) consider(u);
  if (!best) return best;
  const VectorXd zero = VectorXd::Zero(dimensions), one = VectorXd::Ones(dimensions);
  consider(minimize_locally([&](const VectorXd& u) { return -f(u); }, zero, one, *best, first_step,
                            evaluations)
               .x);
  return best;
}

}  // namespace

DesignModels::DesignModels(const OptimizationStudy& o, ResponseModel objective,
                           const std::vector<Point>& points)
    : o_(o), objective_(std::move(objective)), surrogate_(objective_.surrogate.best) {
  const int d = static_cast<int>(o.study.parameters.size());
  for (const EventLimit& limit : o.limits) events_.emplace_back(counts_of(o, limit, points), d);
}

DesignPrediction DesignModels::predict(const VectorXd& u) const {
  const Prediction p = surrogate_.predict(u);
  DesignPrediction all;
  all.mean = p.mean;
  all.sd = std::sqrt(p.variance);
  for (std::size_t k = 0; k < events_.size(); ++k) {
    const auto [mean, at_most] = events_[k].predict(u, o_.limits[k].probability);
    all.probabilities.push_back(mean);
    all.kept *= at_most;
  }
  return all;
}

double DesignModels::merit(const VectorXd& u, std::optional<double> incumbent) const {
  const DesignPrediction p = predict(u);
  if (!incumbent) return p.kept;
  const double gain = o_.maximize ? p.mean - *incumbent : *incumbent - p.mean;
  if (!(p.sd > 0)) return std::max(gain, 0.0) * p.kept;
  const double z = gain / p.sd;
  return p.kept * (gain * normal_probability(z) + p.sd * normal_density(z));
}

void DesignModels::believe(const VectorXd& u) {
  const double mean = surrogate_.predict_mean(u);
  surrogate_ =
      surrogate_.with_fantasy_point(u, objective_.run_variance(u, mean) / o_.replicates_per_design);
}

namespace {

class DesignSearch {
 public:
  DesignSearch(const OptimizationStudy& o, StudyRuns& runs, BatchProgress& progress)
      : o_(o), runs_(runs), progress_(progress) {
    r_.optimization = o;
  }

  OptimizationResult result() {
    spread_designs();
    bool fitted = fit();
    for (int round = 1; fitted && designs_left() > 0; ++round) {
      refine(round);
      fitted = fit();
    }
    if (fitted) confirm(choose_best());
    summarize();
    return std::move(r_);
  }

 private:
  int dimensions() const { return static_cast<int>(o_.study.parameters.size()); }
  int designs_left() const { return o_.largest_designs() - static_cast<int>(points_.size()); }
  double sign() const { return o_.maximize ? 1 : -1; }

  void run(std::vector<Point> batch) {
    runs_.run(batch);
    for (const Point& p : batch)
      if (const std::string unit = p.unit(o_.objective()); !unit.empty()) r_.objective_unit = unit;
    points_.insert(points_.end(), batch.begin(), batch.end());
  }

  // Their number does not depend on that of the runs: more runs continue the same search.
  void spread_designs() {
    const int count = std::min(3 * dimensions() + 2, o_.largest_designs());
    std::vector<Point> batch;
    for (const VectorXd& u : maximin_latin_hypercube(count, dimensions(), o_.study.seed, {}))
      batch.push_back(runs_.point("design", static_cast<int>(batch.size()),
                                  rounded_values(o_.study.parameters, u), next_seeds(u, batch)));
    progress_.phase("exploring the ranges");
    run(std::move(batch));
  }

  // The same seeds for every design, so that designs differ by less chance. One that is chosen
  // again gets more of them.
  std::vector<std::uint64_t> next_seeds(const VectorXd& u, const std::vector<Point>& batch) const {
    const std::vector<double> values = rounded_values(o_.study.parameters, u);
    std::uint64_t before = 0;
    for (const auto* points : {&points_, &batch})
      for (const Point& p : *points)
        if (p.values == values) before += p.seeds.size();
    return seed_list(o_.study.seed + before, o_.replicates_per_design);
  }

  // Each run counts once: a compared design may be the best one, or be given twice.
  std::vector<Point> distinct_points() const {
    std::vector<Point> distinct;
    for (const Point& p : points_)
      if (std::ranges::none_of(distinct, [&](const Point& other) {
            return other.values == p.values && other.seeds == p.seeds;
          }))
        distinct.push_back(p);
    return distinct;
  }

  bool fit() {
    const std::vector<Point> points = distinct_points();
    auto objective = fit_response_model(o_.objective(), points);
    if (objective) models_.emplace(o_, std::move(*objective), points);
    return objective.has_value();
  }

  // Of the designs that are likely to keep the limits, the best predicted mean.
  std::optional<double> incumbent() const {
    std::optional<double> best;
    for (const Point& p : points_) {
      const DesignPrediction predicted = models_->predict(p.u);
      if (predicted.kept < likely) continue;
      if (!best || sign() * predicted.mean > sign() * *best) best = predicted.mean;
    }
    return best;
  }

  void refine(int round) {
    std::vector<Point> batch;
    const std::optional<double> best = incumbent();
    for (int i = std::min(o_.designs_per_round, designs_left()); i > 0; --i) {
      const auto log_merit = [&](const VectorXd& u) {
        const bool apart = std::ranges::all_of(batch, [&](const Point& p) {
          return (p.u - u).lpNorm<Eigen::Infinity>() >= least_distance;
        });
        return apart ? std::log(models_->merit(u, best)) : std::nan("");
      };
      auto u = maximum(log_merit, dimensions(), {});
      if (!u) u = quasi_random_point(points_.size() + batch.size(), dimensions());
      batch.push_back(runs_.point(fmt::format("round {}", round), static_cast<int>(batch.size()),
                                  rounded_values(o_.study.parameters, *u), next_seeds(*u, batch)));
      models_->believe(batch.back().u);
    }
    progress_.phase("searching for better designs");
    run(std::move(batch));
  }

  // The best predicted mean among those that keep the limits with the confidence asked for; where
  // there is none, the design that is the most likely to keep them.
  std::vector<double> choose_best() const {
    std::vector<VectorXd> tried;
    for (const Point& p : points_) tried.push_back(p.u);
    const auto kept = [&](const VectorXd& u) { return models_->predict(u).kept; };
    const auto allowed_mean = [&](const VectorXd& u) {
      const DesignPrediction p = models_->predict(u);
      return p.kept >= o_.confidence ? sign() * p.mean : std::nan("");
    };
    auto u = maximum(allowed_mean, dimensions(), tried);
    if (!u) u = maximum(kept, dimensions(), tried);
    return rounded_values(o_.study.parameters, *u);
  }

  void confirm(const std::vector<double>& values) {
    const auto seeds = seed_list(o_.study.seed + confirmation_seeds, o_.confirmation_replicates);
    std::vector<Point> batch = {runs_.point("confirm", 0, values, seeds)};
    for (const CompareSet& set : o_.study.compare)
      batch.push_back(
          runs_.point("compare: " + set.name, static_cast<int>(batch.size()), set.values, seeds));
    progress_.phase("confirming with fresh seeds");
    searched_ = points_.size();
    run(std::move(batch));
  }

  TriedDesign tried(const std::string& name, const Point& p) const {
    TriedDesign t;
    t.name = name;
    t.values = p.values;
    t.runs = static_cast<int>(p.seeds.size());
    t.finished = p.count(JobStatus::finished);
    t.objective = sample(p.finished(o_.objective()));
    for (const EventLimit& limit : o_.limits) {
      const EventCount c = counts_of(o_, limit, {p}).front();
      t.events.push_back({c.events, c.runs, binomial_interval(c.events, c.runs)});
    }
    if (models_) t.predicted = models_->predict(p.u);
    return t;
  }

  DesignDifference difference(const Point& best, const Point& other) const {
    std::vector<double> differences;
    for (std::size_t s = 0; s < best.seeds.size(); ++s) {
      const auto a = best.value(o_.objective(), s), b = other.value(o_.objective(), s);
      if (a && b) differences.push_back(*a - *b);
    }
    const Sample sum = sample(differences);
    DesignDifference d{sum.mean, std::nan(""), std::nan(""), sum.count};
    if (sum.count < 2) return d;
    const double reach = student_factor(sum.count - 1) * sum.sd() / std::sqrt(sum.count);
    d.low = sum.mean - reach;
    d.high = sum.mean + reach;
    return d;
  }

  DesignSlice slice(std::size_t parameter, const VectorXd& through) const {
    constexpr int places = 33;
    DesignSlice s;
    for (int i = 0; i < places; ++i) {
      VectorXd u = through;
      u[static_cast<Eigen::Index>(parameter)] = i / (places - 1.0);
      const DesignPrediction p = models_->predict(u);
      s.values.push_back(o_.study.parameters[parameter].from_unit(i / (places - 1.0)));
      s.mean.push_back(p.mean);
      s.sd.push_back(p.sd);
      s.kept.push_back(p.kept);
    }
    return s;
  }

  // By models of all runs, those of the confirmation included.
  void summarize() {
    if (searched_ > 0 && !fit()) models_.reset();
    const std::size_t searched = searched_ > 0 ? searched_ : points_.size();
    for (std::size_t i = 0; i < searched; ++i)
      r_.designs.push_back(tried(points_[i].phase, points_[i]));
    for (const Point& p : distinct_points()) {
      r_.runs += static_cast<int>(p.seeds.size());
      r_.not_finished += static_cast<int>(p.seeds.size()) - p.count(JobStatus::finished);
    }
    if (searched_ == 0 || !models_) {
      r_.headline = fmt::format("the runs of {} designs gave too few values of {} for a model",
                                points_.size(), o_.objective().label);
      return;
    }
    const Point& best = points_[searched_];
    r_.best = tried("best", best);
    for (std::size_t i = 0; i < o_.study.compare.size(); ++i) {
      const Point& other = points_[searched_ + 1 + i];
      r_.compared.push_back(tried(o_.study.compare[i].name, other));
      r_.gains.push_back(difference(best, other));
    }
    for (std::size_t i = 0; i < o_.study.parameters.size(); ++i)
      r_.slices.push_back(slice(i, best.u));
    const double kept = r_.best->predicted->kept;
    r_.verdict = kept >= o_.confidence ? OptimizationVerdict::recommended
                 : kept >= likely      ? OptimizationVerdict::not_shown
                                       : OptimizationVerdict::none_feasible;
    r_.headline = headline(kept);
  }

  std::string headline(double kept) const {
    const TriedDesign& best = *r_.best;
    std::vector<std::string> values;
    for (std::size_t i = 0; i < best.values.size(); ++i) {
      const Parameter& p = o_.study.parameters[i];
      values.push_back(
          fmt::format("{} = {}{}", p.name, p.text(best.values[i]), unit_suffix(p.unit)));
    }
    std::string text = fmt::format(
        "{}: {} {}", fmt::join(values, ", "), o_.objective().label,
        measured_text(best.objective.mean, best.objective.sd() / std::sqrt(best.objective.count),
                      r_.objective_unit));
    for (std::size_t k = 0; k < o_.limits.size(); ++k)
      text += fmt::format(", {} in {} of {} runs", o_.event_text(o_.limits[k]),
                          best.events[k].events, best.events[k].runs);
    switch (r_.verdict) {
      case OptimizationVerdict::recommended:
        return text;
      case OptimizationVerdict::not_shown:
        return fmt::format("{}; the limits are kept with a probability of {:.2g}, not {:.2g}", text,
                           kept, o_.confidence);
      default:
        return "no design within the ranges is likely to keep the limits; the nearest is " + text;
    }
  }

  const OptimizationStudy& o_;
  StudyRuns& runs_;
  BatchProgress& progress_;
  std::vector<Point> points_;
  std::optional<DesignModels> models_;
  std::size_t searched_ = 0;  // points of the search, once the confirmation has run
  OptimizationResult r_;
};

OptimizationResult carry_out(const OptimizationStudy& o, const OptimizationOptions& options,
                             const std::string& directory) {
  const Study& study = o.study;
  BatchFolder batch(
      directory,
      {"optimize", study_identity(study.text, study.source), o.runs, study.execution.slurm},
      options);
  const interruption::Advice advice(resume_hint(directory));
  StudyRuns runs(study, batch.executor(), batch.journal(), batch.store(), batch.progress(),
                 batch.runs(), options.interrupt);
  OptimizationResult r;
  try {
    r = DesignSearch(o, runs, batch.progress()).result();
  } catch (const BatchInterrupted&) {
    r.verdict = OptimizationVerdict::interrupted;
    r.directory = directory;
    return r;
  }
  r.directory = directory;
  batch.progress().done();
  batch.journal().require_in_place();
  std::vector<JournalRun> asked = batch.journal().runs();
  std::erase_if(asked, [&](const JournalRun& run) { return !runs.was_requested(run.key); });
  write_own_file((fs::path(directory) / "runs.csv").string(), render_runs_csv(study, asked));
  write_own_file((fs::path(directory) / "results.json").string(), render_json(r) + "\n");
  batch.journal().require_in_place();
  return r;
}

}  // namespace

const char* to_string(OptimizationVerdict verdict) {
  switch (verdict) {
    case OptimizationVerdict::recommended:
      return "recommended";
    case OptimizationVerdict::not_shown:
      return "limits not shown to be kept";
    case OptimizationVerdict::none_feasible:
      return "no design keeps the limits";
    case OptimizationVerdict::too_few_runs:
      return "too few runs";
    case OptimizationVerdict::interrupted:
      return "interrupted";
  }
  return "";
}

OptimizationResult optimize_design(const OptimizationOptions& options) {
  const OptimizationStudy o = read_optimization(options.file);
  const std::string directory =
      options.directory.empty() ? (fs::path("runs") / o.study.name).string() : options.directory;
  return with_kept_runs(directory, [&] { return carry_out(o, options, directory); });
}

}  // namespace firn
