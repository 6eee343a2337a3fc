#include "calibrate/study/budget.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "experiments/system/input_limits.h"
#include "experiments/text/units.h"

namespace firn {
namespace {

int part_of(int runs, double share, int least, int most) {
  return std::clamp(static_cast<int>(std::lround(share * runs)), least, most);
}

// Runs at parameter sets that do not depend on the fit.
std::int64_t fixed_runs(const Budget& b, const Study& study) {
  const auto compared = static_cast<std::int64_t>(study.compare.size());
  const auto checks = static_cast<std::int64_t>(study.numerics.size());
  // The middle of the ranges and the pairs once more in the other form.
  const std::int64_t in_both =
      study.low_fidelity
          ? b.center_replicates + std::int64_t{study.low_fidelity->pairs} * b.replicates_per_point
          : 0;
  return b.center_replicates + compared * b.compare_replicates + checks * b.numerics_replicates +
         b.confirmation_replicates + std::int64_t{2} * b.endpoint_replicates + in_both;
}

// Divides `runs`: a tenth for the noise, a tenth for the confirmation, some for the ends of the
// ridge. Two thirds of the rest are the design, one third refines it where runs are most
// informative.
Budget divided(int runs, const Study& study) {
  const int d = static_cast<int>(study.parameters.size());
  Budget b;
  b.replicates_per_point = 2;
  b.center_replicates = part_of(runs, 0.09, 2, 6);
  b.confirmation_replicates = part_of(runs, 0.09, 3, 8);
  b.endpoint_replicates = d < 2 || runs < 20 ? 0 : part_of(runs, 0.055, 2, 5);
  b.compare_replicates = runs < 30 ? 1 : 2;
  b.numerics_replicates = 2;
  b.refine_points = part_of(runs, 0.055, 1, 4);
  const int left = static_cast<int>(runs - fixed_runs(b, study));
  b.design_points = std::max(d + 2, left / 3);  // two runs each: two thirds of what is left
  return b;
}

}  // namespace

int checked_count(const TomlTable& t, const char* key, int value) {
  if (value > input_limits::batch_runs)
    t.fail(key, fmt::format("is {}; expected at most {}", value, input_limits::batch_runs));
  return value;
}

Budget read_budget(const TomlTable& root, const Study& study) {
  const TomlTable t = root.required_table("budget");
  t.allow({"runs", "time", "center_replicates", "numerics_replicates", "design_points",
           "replicates_per_point", "refine_rounds", "refine_points", "confirmation_replicates",
           "endpoint_replicates", "compare_replicates", "min_improvement", "reuse"});
  // Each choice gets its own share, and each experiment of it.
  const int shares = static_cast<int>(study.experiments.size()) * study.choice_count();
  const bool bounded = t.has("runs"), by_time = t.has("time");
  const int runs = bounded ? checked_count(t, "runs", t.integer("runs", 1)) / shares : 0;
  const Budget plan = bounded ? divided(runs, study) : Budget{};
  // With `runs`, keys that are not given follow from the division; given keys have priority.
  const auto read = [&](const char* key, int least, int planned, std::optional<int> usual = {}) {
    if (bounded) return checked_count(t, key, t.integer(key, least, planned));
    return checked_count(t, key, usual ? t.integer(key, least, *usual) : t.integer(key, least));
  };
  Budget b;
  b.runs = runs;
  b.reuse = t.boolean("reuse", true);
  b.center_replicates = read("center_replicates", 1, plan.center_replicates);
  b.numerics_replicates = read("numerics_replicates", 1, plan.numerics_replicates, 2);
  b.design_points = read("design_points", 1, plan.design_points);
  b.allow_single_replicate =
      bounded && !t.has("replicates_per_point");  // asked before a default is put there
  b.replicates_per_point = read("replicates_per_point", 1, plan.replicates_per_point);
  b.refine_points = read("refine_points", 0, plan.refine_points, 2);
  b.confirmation_replicates = read("confirmation_replicates", 2, plan.confirmation_replicates, 3);
  b.endpoint_replicates = read("endpoint_replicates", 0, plan.endpoint_replicates, 0);
  b.compare_replicates = read("compare_replicates", 0, plan.compare_replicates, 1);
  b.time = t.optional_quantity("time", dimension::time, Sign::positive).value_or(0);
  b.min_improvement = t.number("min_improvement", b.min_improvement);
  if (!(b.min_improvement >= 0 && b.min_improvement < 1))
    t.fail("min_improvement",
           fmt::format("is {}; expected a fraction of at least 0 and below 1", b.min_improvement));
  const std::int64_t per_point = b.replicates_per_point, batch = b.refine_points * per_point;
  const std::int64_t left = runs - fixed_runs(b, study) - b.design_points * per_point;
  if (bounded && left < 0)
    t.fail("runs", fmt::format("{} are too few: noise, design, confirmation and what is compared "
                               "take {}; expected at least that",
                               runs * shares, (runs - left) * shares));
  constexpr int rounds_by_time = 50;
  const int rounds = bounded && batch > 0 ? static_cast<int>(left / batch)
                     : by_time            ? rounds_by_time
                                          : 1;
  b.rounds_stated = t.has("refine_rounds");
  b.refine_rounds = checked_count(t, "refine_rounds", t.integer("refine_rounds", 0, rounds));
  // A linear trend has one coefficient more than there are parameters.
  const int needed = static_cast<int>(study.parameters.size()) + 1;
  if (b.design_points < needed)
    t.fail("design_points",
           fmt::format("{} cannot carry a fit of {} parameters; expected at least {}",
                       b.design_points, study.parameters.size(), needed));
  if (b.center_replicates < 2 && b.replicates_per_point < 2)
    t.fail("center_replicates",
           "leaves no point with two seeds, so that the noise stays unknown; expected at least 2 "
           "here or in replicates_per_point");
  return b;
}

int Study::largest_total() const {
  const auto each = static_cast<std::int64_t>(experiments.size()) * choice_count();
  const std::int64_t per_point = budget.replicates_per_point, rounds = budget.refine_rounds;
  const std::int64_t points = budget.design_points + rounds * budget.refine_points;
  std::int64_t seeds = budget.runs;
  if (direct != DirectSearch::none)
    seeds = direct_evaluations * per_point + budget.confirmation_replicates +
            static_cast<std::int64_t>(compare.size()) * budget.compare_replicates;
  else if (seeds == 0)
    seeds = fixed_runs(budget, *this) + points * per_point;
  // No study has so many: read_study() refuses it.
  constexpr std::int64_t most = input_limits::batch_runs + 1;
  return static_cast<int>(std::min(most, std::min(most, seeds) * each));
}

}  // namespace firn
