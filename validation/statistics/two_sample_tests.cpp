#include "validation/statistics/two_sample_tests.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <cassert>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

#include "experiments/analysis/sample_statistics.h"
#include "validation/statistics/estimated_variance.h"
#include "validation/statistics/random_order.h"

namespace firn {
namespace {

constexpr double most_splits = 20000, level = 0.05;
constexpr int random_splits = 1999;
constexpr double alike = 0.25;  // at smaller p, values of one run count as dependent
constexpr double beyond = 2;    // larger than any distance, which is at most 1

double splits(std::size_t a, std::size_t b) {
  double number = 1;
  for (std::size_t i = 1; i <= std::min(a, b) && number <= most_splits; ++i)
    number *= static_cast<double>(a + b - i + 1) / static_cast<double>(i);
  return number;
}

struct Pair {
  double distance = 0, other = 0;
};
using Labels = std::vector<char>;  // of the pooled values in order: 1 in a, 0 in b

// Statistics of all ways to split the pooled values. Where these are too many: of the observed
// split, then of random ones.
std::vector<Pair> under_exchange(const Labels& observed, std::size_t a,
                                 const std::function<Pair(const Labels&)>& statistics) {
  std::vector<Pair> all;
  Labels labels = observed;
  all.push_back(statistics(labels));
  if (splits(a, labels.size() - a) <= most_splits) {
    std::ranges::sort(labels, std::greater<>());
    all.pop_back();
    do all.push_back(statistics(labels));
    while (std::prev_permutation(labels.begin(), labels.end()));
    return all;
  }
  RandomOrder dealer;
  for (int k = 0; k < random_splits; ++k) {
    dealer.shuffle(labels);
    all.push_back(statistics(labels));
  }
  return all;
}

double slack(double x) { return 1e-10 * std::abs(x) + 1e-300; }

// Fraction of the sorted values that are at least x.
double share_from(const std::vector<double>& sorted, double x) {
  const auto first = std::ranges::lower_bound(sorted, x - slack(x));
  return static_cast<double>(sorted.end() - first) / static_cast<double>(sorted.size());
}

// The smallest of sorted values that at most `level` of them reach.
double critical_value(const std::vector<double>& sorted) {
  for (std::size_t i = 0; i < sorted.size(); ++i)
    if (share_from(sorted, sorted[i]) <= level) return sorted[i];
  return beyond;
}

SampleTest judge(const Pair& observed, const std::vector<Pair>& all) {
  std::vector<double> distances, others, least;
  for (const Pair& p : all) {
    distances.push_back(p.distance);
    others.push_back(p.other);
  }
  std::ranges::sort(distances);
  std::ranges::sort(others);
  SampleTest t;
  t.distance = observed.distance;
  t.area = observed.other;
  t.distance_p = share_from(distances, observed.distance);
  t.area_p = share_from(others, observed.other);
  const double mine = std::min(t.distance_p, t.area_p);
  int as_small = 0;
  for (const Pair& p : all)
    as_small +=
        std::min(share_from(distances, p.distance), share_from(others, p.other)) <= mine + 1e-12;
  t.p = static_cast<double>(as_small) / static_cast<double>(all.size());
  t.critical = critical_value(distances);
  return t;
}

struct Entry {
  double x = 0;
  bool in_a = false, passed = true;
};

// Smirnov's distance, and the area between the cumulative distributions. `pooled` is in order.
Pair distances_of(const std::vector<Entry>& pooled, const Labels& labels, double a, double b) {
  Pair p;
  double i = 0, j = 0;
  for (std::size_t k = 0; k < pooled.size(); ++k) {
    (labels[k] != 0 ? i : j) += 1;
    const bool last = k + 1 == pooled.size();
    const double width = last ? 0 : pooled[k + 1].x - pooled[k].x;
    if (width <= 0 && !last) continue;
    const double apart = std::abs(i / a - j / b);
    p.distance = std::max(p.distance, apart);
    p.other += apart * width;
  }
  return p;
}

// Largest difference of the Kaplan-Meier estimates, and difference of the mean log-rank scores.
Pair open_distances_of(const std::vector<Entry>& pooled, const std::vector<double>& scores,
                       const Labels& labels, double a, double b) {
  Pair p;
  double at_risk_a = a, at_risk_b = b, inside_a = 1, inside_b = 1, sum_a = 0, sum_b = 0;
  for (std::size_t k = 0; k < pooled.size();) {
    double pass_a = 0, pass_b = 0, leave_a = 0, leave_b = 0;
    const double x = pooled[k].x;
    for (; k < pooled.size() && pooled[k].x == x; ++k) {
      const bool mine = labels[k] != 0;
      (mine ? sum_a : sum_b) += scores[k];
      (mine ? leave_a : leave_b) += 1;
      if (pooled[k].passed) (mine ? pass_a : pass_b) += 1;
    }
    if (pass_a > 0) inside_a *= 1 - pass_a / at_risk_a;
    if (pass_b > 0) inside_b *= 1 - pass_b / at_risk_b;
    at_risk_a -= leave_a;
    at_risk_b -= leave_b;
    p.distance = std::max(p.distance, std::abs(inside_a - inside_b));
    // A sample that ends with censored values has no information on later times.
    if ((at_risk_a <= 0 && inside_a > 0) || (at_risk_b <= 0 && inside_b > 0)) {
      for (; k < pooled.size(); ++k) (labels[k] != 0 ? sum_a : sum_b) += scores[k];
    }
  }
  p.other = std::abs(sum_a / a - sum_b / b);
  return p;
}

// One less the expected number of events up to each time, in the order of the pool.
std::vector<double> log_rank_scores(const std::vector<Entry>& pooled) {
  std::vector<double> scores(pooled.size());
  double hazard = 0;
  for (std::size_t k = 0; k < pooled.size();) {
    std::size_t next = k;
    double pass = 0;
    for (; next < pooled.size() && pooled[next].x == pooled[k].x; ++next)
      pass += pooled[next].passed ? 1 : 0;
    hazard += pass / static_cast<double>(pooled.size() - k);
    for (; k < next; ++k) scores[k] = (pooled[k].passed ? 1 : 0) - hazard;
  }
  return scores;
}

Labels labels_of(const std::vector<Entry>& pooled) {
  Labels labels;
  for (const Entry& e : pooled) labels.push_back(e.in_a ? 1 : 0);
  return labels;
}

// One-way analysis of variance.
struct Scatter {
  double between = 0, within = 0;  // mean squares
  double between_freedom = 0, within_freedom = 0;
  double size = 0;     // of a run, for the component between runs
  double squares = 0;  // sum of squares of run sizes over the square of the number of values
  double count = 0, mean = 0;
};
Scatter scatter_of(const ValuesByRun& runs) {
  Scatter s;
  double sum = 0, squares = 0, used = 0;
  for (const auto& run : runs) {
    for (const double v : run) sum += v;
    s.count += static_cast<double>(run.size());
    squares += static_cast<double>(run.size() * run.size());
    used += run.empty() ? 0 : 1;
  }
  s.mean = sum / s.count;
  for (const auto& run : runs) {
    if (run.empty()) continue;
    const SampleStatistics f = sample_statistics(run);
    s.between += f.count * (f.mean - s.mean) * (f.mean - s.mean);
    for (const double v : run) s.within += (v - f.mean) * (v - f.mean);
  }
  s.between_freedom = used - 1;
  s.within_freedom = s.count - used;
  s.between /= s.between_freedom;
  s.within /= s.within_freedom;
  s.size = (s.count - squares / s.count) / s.between_freedom;
  s.squares = squares / (s.count * s.count);
  return s;
}

bool are_alike(const ValuesByRun& runs) {
  const Scatter s = scatter_of(runs);
  if (s.between_freedom < 1 || s.within_freedom < 1 || s.between <= s.within) return false;
  if (s.within <= 0) return true;
  const boost::math::fisher_f f(s.between_freedom, s.within_freedom);
  return boost::math::cdf(boost::math::complement(f, s.between / s.within)) < alike;
}

// Noise of the difference of two means: that of the experiment's `n` values, as of one more run,
// and that of the values of all runs.
Noise noise_of_means(const Scatter& s, double n) {
  Noise noise;
  noise.estimates = {{s.between, s.between_freedom}, {s.within, s.within_freedom}};
  const double runs = (1 + s.squares) / s.size;
  noise.terms = {{{0, runs}, {1, -runs}}, {{1, 1 / n + 1 / s.count}}};
  return noise;
}

// Scores of the pooled values, by run and for the experiment.
struct Scores {
  ValuesByRun runs;
  std::vector<double> measured;
};

// Compares the mean scores of the experiment with those of runs. Of several scores, the smallest
// p counts, times their number (Bonferroni).
void judge_by_runs(const std::vector<Scores>& scores, SampleTest& t) {
  double p = 1;
  for (const Scores& s : scores) {
    const Scatter scatter = scatter_of(s.runs);
    const Noise noise = noise_of_means(scatter, static_cast<double>(s.measured.size()));
    p = std::min(p, exceedance(noise, std::abs(mean(s.measured) - scatter.mean)));
  }
  t.dependent = true;
  t.p = t.distance_p = t.area_p = std::min(1.0, p * static_cast<double>(scores.size()));
}

// Rank of each sorted value over their number; equal values share their mean rank.
std::vector<double> ranks_of(const std::vector<double>& sorted) {
  std::vector<double> ranks(sorted.size());
  for (std::size_t k = 0; k < sorted.size();) {
    std::size_t next = k;
    while (next < sorted.size() && sorted[next] == sorted[k]) ++next;
    const double rank = static_cast<double>(k + next) / 2 / static_cast<double>(sorted.size());
    for (; k < next; ++k) ranks[k] = rank;
  }
  return ranks;
}

std::vector<double> joined(const ValuesByRun& runs) {
  std::vector<double> all;
  for (const auto& run : runs) all.insert(all.end(), run.begin(), run.end());
  return all;
}

Scores rank_scores(const ValuesByRun& runs, const std::vector<double>& measured) {
  std::vector<double> sorted = joined(runs);
  sorted.insert(sorted.end(), measured.begin(), measured.end());
  std::ranges::sort(sorted);
  const std::vector<double> ranks = ranks_of(sorted);
  const auto of = [&](std::vector<double> values) {
    for (double& v : values)
      v = ranks[static_cast<std::size_t>(std::ranges::lower_bound(sorted, v) - sorted.begin())];
    return values;
  };
  Scores s;
  for (const auto& run : runs) s.runs.push_back(of(run));
  s.measured = of(measured);
  return s;
}

Scores spread_of(Scores s) {
  const auto turn = [](std::vector<double>& values) {
    for (double& v : values) v = std::abs(v - 0.5);
  };
  for (auto& run : s.runs) turn(run);
  turn(s.measured);
  return s;
}

// Twice the smallest significant difference of the mean ranks. Moving half of the values beyond
// all others changes the mean rank by a quarter, and the distance by a half.
double critical_by_runs(const Scores& ranks) {
  const Scatter s = scatter_of(ranks.runs);
  if (s.between_freedom < 2) return beyond;
  return 2 * expanded_uncertainty(noise_of_means(s, static_cast<double>(ranks.measured.size())),
                                  1 - level / 2);
}

// Censoring time: the last time of a particle that did not pass. Infinite if a particle passed
// at that time or later.
double censoring_time(const CensoredTimes& t) {
  const auto last = [](const std::vector<double>& v) {
    return v.empty() ? -std::numeric_limits<double>::infinity() : *std::ranges::max_element(v);
  };
  return last(t.passed) >= last(t.inside) ? std::numeric_limits<double>::infinity()
                                          : last(t.inside);
}

CensoredTimes cut(const CensoredTimes& t, double at) {
  CensoredTimes c;
  for (const double x : t.passed) (x > at ? c.inside : c.passed).push_back(std::min(x, at));
  for (const double x : t.inside) c.inside.push_back(std::min(x, at));
  return c;
}

double sum_of(const std::vector<double>& v) { return std::accumulate(v.begin(), v.end(), 0.0); }

// Pearson's statistic of a table of counts, and its degrees of freedom.
struct Pearson {
  double statistic = 0, freedom = 0;
};
Pearson pearson(const std::vector<std::vector<double>>& table) {
  std::vector<double> columns(table.front().size(), 0);
  double all = 0, rows = 0;
  for (const auto& row : table) {
    for (std::size_t k = 0; k < columns.size(); ++k) columns[k] += row[k];
    all += sum_of(row);
    rows += sum_of(row) > 0 ? 1 : 0;
  }
  Pearson p;
  for (const auto& row : table)
    for (std::size_t k = 0; k < columns.size(); ++k)
      if (const double expected = sum_of(row) * columns[k] / all; expected > 0)
        p.statistic += (row[k] - expected) * (row[k] - expected) / expected;
  const auto used =
      static_cast<double>(std::ranges::count_if(columns, [](double c) { return c > 0; }));
  p.freedom = (rows - 1) * (used - 1);
  return p;
}

}  // namespace

SampleTest exchange_test(const std::vector<double>& a, const std::vector<double>& b) {
  assert(!a.empty() && !b.empty());
  std::vector<Entry> pooled;
  pooled.reserve(a.size() + b.size());
  for (const double x : a) pooled.push_back({x, true});
  for (const double x : b) pooled.push_back({x, false});
  std::ranges::stable_sort(pooled, {}, &Entry::x);
  const auto statistics = [&](const Labels& labels) {
    return distances_of(pooled, labels, static_cast<double>(a.size()),
                        static_cast<double>(b.size()));
  };
  const Labels labels = labels_of(pooled);
  return judge(statistics(labels), under_exchange(labels, a.size(), statistics));
}

SampleTest compare_samples(const ValuesByRun& runs, const std::vector<double>& measured) {
  SampleTest t = exchange_test(joined(runs), measured);
  const Scores ranks = rank_scores(runs, measured);
  if (!are_alike(ranks.runs)) return t;
  judge_by_runs({ranks, spread_of(ranks)}, t);
  t.critical = critical_by_runs(ranks);
  return t;
}

SampleTest compare_open_times(const std::vector<CensoredTimes>& runs,
                              const CensoredTimes& measured) {
  CensoredTimes simulated;
  for (const CensoredTimes& run : runs) {
    simulated.passed.insert(simulated.passed.end(), run.passed.begin(), run.passed.end());
    simulated.inside.insert(simulated.inside.end(), run.inside.begin(), run.inside.end());
  }
  const double end = std::min(censoring_time(simulated), censoring_time(measured));
  struct Owned : Entry {
    std::size_t run = 0;  // the last of them is the experiment
  };
  std::vector<Owned> owned;
  const auto add = [&](const CensoredTimes& t, std::size_t run, bool in_a) {
    const CensoredTimes c = cut(t, end);
    for (const double x : c.passed) owned.push_back({{x, in_a, true}, run});
    for (const double x : c.inside) owned.push_back({{x, in_a, false}, run});
  };
  for (std::size_t r = 0; r < runs.size(); ++r) add(runs[r], r, true);
  add(measured, runs.size(), false);
  // At equal times, events come before censored values (convention of Kaplan and Meier).
  std::ranges::stable_sort(owned, [](const Owned& p, const Owned& q) {
    return p.x != q.x ? p.x < q.x : p.passed && !q.passed;
  });
  const std::vector<Entry> pooled(owned.begin(), owned.end());
  const std::vector<double> scores = log_rank_scores(pooled);
  const auto a = static_cast<std::size_t>(std::ranges::count(pooled, true, &Entry::in_a));
  const auto statistics = [&](const Labels& labels) {
    return open_distances_of(pooled, scores, labels, static_cast<double>(a),
                             static_cast<double>(pooled.size() - a));
  };
  const Labels labels = labels_of(pooled);
  SampleTest t = judge(statistics(labels), under_exchange(labels, a, statistics));
  t.area = std::numeric_limits<double>::quiet_NaN();
  Scores by_run;
  by_run.runs.resize(runs.size());
  for (std::size_t k = 0; k < owned.size(); ++k)
    (owned[k].run < runs.size() ? by_run.runs[owned[k].run] : by_run.measured).push_back(scores[k]);
  if (!are_alike(by_run.runs)) return t;
  judge_by_runs({by_run}, t);
  // Scores in units of ranks: these scatter by 1/sqrt(12).
  const Scatter s = scatter_of(by_run.runs);
  const double unit = std::sqrt(12 * (s.within > 0 ? s.within : 1));
  t.critical = s.between_freedom < 2 ? beyond
                                     : 2 / unit *
                                           expanded_uncertainty(noise_of_means(
                                               s, static_cast<double>(by_run.measured.size())));
  return t;
}

ShareTest compare_shares(const std::vector<std::vector<double>>& runs,
                         const std::vector<double>& measured) {
  std::vector<double> simulated(measured.size(), 0);
  for (const auto& run : runs)
    for (std::size_t k = 0; k < run.size(); ++k) simulated[k] += run[k];
  ShareTest t;
  t.distance = total_variation_distance(simulated, measured);
  std::vector<std::size_t> things;  // their classes, those of the simulation first
  for (const std::vector<double>* counts : {&std::as_const(simulated), &measured})
    for (std::size_t k = 0; k < counts->size(); ++k)
      things.insert(things.end(), static_cast<std::size_t>(std::llround((*counts)[k])), k);
  const double ours = sum_of(simulated), theirs = sum_of(measured);
  const auto first = static_cast<std::size_t>(std::llround(ours));
  RandomOrder dealer;
  std::vector<double> distances = {t.distance};
  for (int draw = 0; draw < random_splits; ++draw) {
    dealer.shuffle(things);
    std::vector<double> x(measured.size(), 0), y(measured.size(), 0);
    for (std::size_t k = 0; k < things.size(); ++k) (k < first ? x : y)[things[k]] += 1;
    distances.push_back(total_variation_distance(x, y));
  }
  std::ranges::sort(distances);
  t.p = share_from(distances, t.distance);
  t.critical = critical_value(distances);
  const Pearson between = pearson(runs);
  if (between.freedom < 1) return t;
  const boost::math::chi_squared chance(between.freedom);
  if (boost::math::cdf(boost::math::complement(chance, between.statistic)) >= alike) return t;
  // Counts in a row of `n` things vary 1 + (n - 1) r times as much as a multinomial's.
  const double mean_size = ours / static_cast<double>(runs.size());
  t.dispersion = std::max(1.0, between.statistic / between.freedom);
  const double r = mean_size > 1 ? (t.dispersion - 1) / (mean_size - 1) : 0;
  const double wider =
      ((1 + (theirs - 1) * r) / theirs + t.dispersion / ours) / (1 / theirs + 1 / ours);
  const Pearson apart = pearson({simulated, measured});
  if (apart.freedom < 1) return t;
  const boost::math::fisher_f f(apart.freedom, between.freedom);
  t.p = boost::math::cdf(boost::math::complement(f, apart.statistic / apart.freedom / wider));
  t.critical *= std::sqrt(wider);
  return t;
}

}  // namespace firn
