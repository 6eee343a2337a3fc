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

// Runs at the parameter sets that are asked for whatever the fit will say.
std::int64_t fixed_runs(const Budget& b, const Study& study) {
  const auto compared = static_cast<std::int64_t>(study.compare.size());
  const auto checks = static_cast<std::int64_t>(study.numerics.size());
  return b.centre_runs + compared * b.compare_runs + checks * b.numerics_runs + b.confirm_runs +
         std::int64_t{2} * b.anchor_runs;
}

// A tenth for the noise, a tenth to confirm the answer, some for the ends of the valley; of the
// rest two thirds spread over the ranges and one third where runs are most informative.
Budget divided(int runs, const Study& study) {
  const int d = static_cast<int>(study.parameters.size());
  Budget b;
  b.runs_per_point = 2;
  b.centre_runs = part_of(runs, 0.09, 2, 6);
  b.confirm_runs = part_of(runs, 0.09, 3, 8);
  b.anchor_runs = d < 2 || runs < 20 ? 0 : part_of(runs, 0.055, 2, 5);
  b.compare_runs = runs < 30 ? 1 : 2;
  b.numerics_runs = 2;
  b.refine_points = part_of(runs, 0.055, 1, 4);
  const int left = static_cast<int>(runs - fixed_runs(b, study));
  b.design_points = std::max(d + 2, left / 3);  // two runs each: two thirds of what is left
  return b;
}

// A number of runs, points or rounds.
int limited(const TomlTable& t, const char* key, int value) {
  if (value > input_limits::batch_runs)
    t.fail(key, fmt::format("is {}; expected at most {}", value, input_limits::batch_runs));
  return value;
}

}  // namespace

Budget read_budget(const TomlTable& root, const Study& study) {
  const TomlTable t = root.required_table("budget");
  t.allow({"runs", "time", "center_replicates", "numerics_replicates", "design_points",
           "replicates_per_point", "refine_rounds", "refine_points", "confirmation_replicates",
           "endpoint_replicates", "compare_replicates", "min_improvement", "reuse"});
  const int experiments = static_cast<int>(study.experiments.size());
  const bool bounded = t.has("runs"), by_time = t.has("time");
  const int runs = bounded ? limited(t, "runs", t.integer("runs", 1)) / experiments : 0;
  const Budget plan = bounded ? divided(runs, study) : Budget{};
  // A number of runs divides itself; whatever is said besides holds.
  const auto read = [&](const char* key, int least, int planned, std::optional<int> usual = {}) {
    if (bounded) return limited(t, key, t.integer(key, least, planned));
    return limited(t, key, usual ? t.integer(key, least, *usual) : t.integer(key, least));
  };
  Budget b;
  b.runs = runs;
  b.reuse = t.boolean("reuse", true);
  b.centre_runs = read("center_replicates", 1, plan.centre_runs);
  b.numerics_runs = read("numerics_replicates", 1, plan.numerics_runs, 2);
  b.design_points = read("design_points", 1, plan.design_points);
  b.trades_seeds =
      bounded && !t.has("replicates_per_point");  // asked before a default is put there
  b.runs_per_point = read("replicates_per_point", 1, plan.runs_per_point);
  b.refine_points = read("refine_points", 0, plan.refine_points, 2);
  b.confirm_runs = read("confirmation_replicates", 2, plan.confirm_runs, 3);
  b.anchor_runs = read("endpoint_replicates", 0, plan.anchor_runs, 0);
  b.compare_runs = read("compare_replicates", 0, plan.compare_runs, 1);
  b.time = t.optional_quantity("time", dimension::time, Sign::positive).value_or(0);
  b.least_gain = t.number("min_improvement", b.least_gain);
  if (!(b.least_gain >= 0 && b.least_gain < 1))
    t.fail("min_improvement",
           fmt::format("is {}; expected a fraction of at least 0 and below 1", b.least_gain));
  const std::int64_t per_point = b.runs_per_point, batch = b.refine_points * per_point;
  const std::int64_t left = runs - fixed_runs(b, study) - b.design_points * per_point;
  if (bounded && left < 0)
    t.fail("runs", fmt::format("{} are too few: noise, design, confirmation and what is compared "
                               "take {}; expected at least that",
                               runs * experiments, (runs - left) * experiments));
  constexpr int rounds_by_time = 50;
  const int rounds = bounded && batch > 0 ? static_cast<int>(left / batch)
                     : by_time            ? rounds_by_time
                                          : 1;
  b.rounds_stated = t.has("refine_rounds");
  b.refine_rounds = limited(t, "refine_rounds", t.integer("refine_rounds", 0, rounds));
  // A linear trend has one coefficient more than there are parameters; one more point judges it.
  const int needed = static_cast<int>(study.parameters.size()) + 1;
  if (b.design_points < needed)
    t.fail("design_points",
           fmt::format("{} cannot carry a fit of {} parameters; expected at least {}",
                       b.design_points, study.parameters.size(), needed));
  if (b.centre_runs < 2 && b.runs_per_point < 2)
    t.fail("center_replicates",
           "leaves no point with two seeds, so that the noise stays unknown; expected at least 2 "
           "here or in replicates_per_point");
  return b;
}

int Study::largest_total() const {
  const auto each = static_cast<std::int64_t>(experiments.size());
  const std::int64_t per_point = budget.runs_per_point, rounds = budget.refine_rounds;
  const std::int64_t points = budget.design_points + rounds * budget.refine_points;
  std::int64_t seeds = budget.runs;
  if (direct != DirectSearch::none)
    seeds = direct_evaluations * per_point + budget.confirm_runs +
            static_cast<std::int64_t>(compare.size()) * budget.compare_runs;
  else if (seeds == 0)
    seeds = fixed_runs(budget, *this) + points * per_point;
  // No study has so many: read_study() refuses it.
  constexpr std::int64_t most = input_limits::batch_runs + 1;
  return static_cast<int>(std::min(most, std::min(most, seeds) * each));
}

}  // namespace firn
