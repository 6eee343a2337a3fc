#include "validation/statistics.h"

#include <fmt/core.h>

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include "solver/types.h"

namespace firn {
namespace {

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
constexpr double most_splits = 20000;

// The value of the empirical distribution of a sorted sample.
double share_up_to(const std::vector<double>& sorted, double x) {
  return static_cast<double>(std::ranges::upper_bound(sorted, x) - sorted.begin()) /
         static_cast<double>(sorted.size());
}

std::vector<double> sorted(std::vector<double> values) {
  std::ranges::sort(values);
  return values;
}

std::vector<double> joined(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> all = a;
  all.insert(all.end(), b.begin(), b.end());
  return sorted(std::move(all));
}

// Whole numbers below `limit`, the same everywhere.
class Dealer {
 public:
  std::size_t below(std::size_t limit) {
    const std::uint64_t most = std::mt19937_64::max() - std::mt19937_64::max() % limit;
    std::uint64_t r = bits_();
    while (r >= most) r = bits_();
    return static_cast<std::size_t>(r % limit);
  }
  template <class T>
  void shuffle(std::vector<T>& values) {
    for (std::size_t i = values.size(); i > 1; --i) std::swap(values[i - 1], values[below(i)]);
  }

 private:
  std::mt19937_64 bits_{20260101};
};

double splits(std::size_t a, std::size_t b) {
  double number = 1;
  for (std::size_t i = 1; i <= std::min(a, b) && number <= most_splits; ++i)
    number *= static_cast<double>(a + b - i + 1) / static_cast<double>(i);
  return number;
}

}  // namespace

double SampleFacts::error() const {
  return count < 2 ? nothing : deviation / std::sqrt(static_cast<double>(count));
}

SampleFacts facts_of(const std::vector<double>& values) {
  SampleFacts f;
  f.count = static_cast<int>(values.size());
  f.mean = values.empty() ? nothing : 0;
  for (const double v : values) f.mean += v / f.count;
  double squares = 0;
  for (const double v : values) squares += (v - f.mean) * (v - f.mean);
  f.deviation = f.count < 2 ? nothing : std::sqrt(squares / (f.count - 1));
  return f;
}

Interval binomial_interval(int successes, int trials, double confidence) {
  assert(0 <= successes && successes <= trials);
  if (trials == 0) return {0, 1};
  using Binomial = boost::math::binomial_distribution<double>;
  const double tail = (1 - confidence) / 2;
  return {successes == 0 ? 0 : Binomial::find_lower_bound_on_p(trials, successes, tail),
          successes == trials ? 1 : Binomial::find_upper_bound_on_p(trials, successes, tail)};
}

double student_factor(double degrees_of_freedom, double confidence) {
  return boost::math::quantile(boost::math::students_t(degrees_of_freedom), (1 + confidence) / 2);
}

Interval DistributionBand::at(double value) const {
  const auto next = std::ranges::upper_bound(x, value);
  if (next == x.begin()) return {0, 0};
  const auto i = static_cast<std::size_t>(next - x.begin()) - 1;
  return {lower[i], upper[i]};
}

DistributionBand empirical_distribution(std::vector<double> values) {
  values = sorted(std::move(values));
  DistributionBand band;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i + 1 < values.size() && values[i + 1] == values[i]) continue;
    band.x.push_back(values[i]);
    band.lower.push_back(static_cast<double>(i + 1) / static_cast<double>(values.size()));
  }
  band.upper = band.lower;
  return band;
}

DistributionBand distribution_from_summary(int n, double minimum, double maximum, double mean) {
  const int inner = n - 2;  // values of which only the sum is known
  const double sum = n * mean - minimum - maximum, slack = 1e-9 * n * (std::abs(maximum) + 1e-300);
  if (n < 2 || minimum > maximum || sum < inner * minimum - slack || sum > inner * maximum + slack)
    throw InputError(
        fmt::format("no {} values lie between {:.6g} and {:.6g} and have the mean {:.6g}; expected "
                    "smallest <= mean <= largest value that go together",
                    n, minimum, maximum, mean));
  // k of the inner values can lie at or below x as long as the others can make up for it, and k
  // above it in the same way.
  DistributionBand band;
  band.x = {minimum, maximum};
  for (int k = 1; k <= inner; ++k) {
    band.x.push_back((sum - (inner - k) * maximum) / k);
    band.x.push_back((sum - (inner - k) * minimum) / k);
  }
  std::erase_if(band.x, [&](double x) { return x < minimum || x > maximum; });
  std::ranges::sort(band.x);
  band.x.erase(std::unique(band.x.begin(), band.x.end()), band.x.end());
  for (const double x : band.x) {
    int below = 0, above = 0;  // as many as can be
    for (int k = 1; k <= inner; ++k) {
      if (sum <= k * x + (inner - k) * maximum + slack) below = k;
      if (sum > k * x + (inner - k) * minimum + slack) above = k;
    }
    const bool end = x >= maximum;
    band.upper.push_back(end ? 1 : (1.0 + below) / n);
    band.lower.push_back(end ? 1 : (1.0 + inner - above) / n);
  }
  return band;
}

std::optional<DistributionBand> distribution_of(const Measurement& m) {
  if (m.scatter == ScatterKind::values) return empirical_distribution(m.values);
  if (m.scatter == ScatterKind::range)
    return distribution_from_summary(m.repeats, m.minimum, m.maximum, m.value);
  return std::nullopt;
}

double distribution_band_width(int n, double confidence) {
  return std::sqrt(std::log(2 / (1 - confidence)) / (2.0 * n));
}

Interval area_metric(const std::vector<double>& sample, const DistributionBand& other) {
  const std::vector<double> mine = sorted(sample), at = joined(mine, other.x);
  Interval area;
  for (std::size_t i = 0; i + 1 < at.size(); ++i) {
    const double width = at[i + 1] - at[i], f = share_up_to(mine, at[i]);
    const Interval g = other.at(at[i]);
    area.low += width * std::max({0.0, g.low - f, f - g.high});
    area.high += width * std::max(std::abs(f - g.low), std::abs(f - g.high));
  }
  return area;
}

double wasserstein_distance(const std::vector<double>& a, const std::vector<double>& b) {
  return area_metric(a, empirical_distribution(b)).high;
}

double smirnov_distance(const std::vector<double>& a, const std::vector<double>& b) {
  const std::vector<double> x = sorted(a), y = sorted(b);
  double largest = 0;
  for (const double at : joined(x, y))
    largest = std::max(largest, std::abs(share_up_to(x, at) - share_up_to(y, at)));
  return largest;
}

// Every order in which the pooled values can belong to the two samples is one path on a grid, and
// all paths are equally likely; counted are those that stay below the distance wherever the pooled
// value changes.
double smirnov_p_value(const std::vector<double>& a, const std::vector<double>& b) {
  const std::vector<double> pooled = joined(a, b);
  const double distance = smirnov_distance(a, b) - 1e-12;
  const double m = static_cast<double>(a.size()), n = static_cast<double>(b.size());
  std::vector<double> within(b.size() + 1, 0);  // of the paths to (i, j), those never outside
  for (std::size_t i = 0; i <= a.size(); ++i)
    for (std::size_t j = 0; j <= b.size(); ++j) {
      const double di = static_cast<double>(i), dj = static_cast<double>(j);
      double& f = within[j];
      if (i + j == 0)
        f = 1;
      else
        f = (i > 0 ? di * f : 0) / (di + dj) + (j > 0 ? dj * within[j - 1] : 0) / (di + dj);
      const bool changes =
          i + j == pooled.size() || (i + j > 0 && pooled[i + j] > pooled[i + j - 1]);
      if (changes && std::abs(di / m - dj / n) >= distance) f = 0;
    }
  return std::clamp(1 - within.back(), 0.0, 1.0);
}

double permutation_p_value(
    const std::vector<double>& a, const std::vector<double>& b,
    const std::function<double(const std::vector<double>&, const std::vector<double>&)>& statistic,
    int draws) {
  const double observed = statistic(a, b), slack = 1e-12 * (std::abs(observed) + 1e-300);
  std::vector<double> pooled = joined(a, b), x(a.size()), y(b.size());
  int as_large = 0, all = 0;
  const auto count = [&](const std::vector<bool>& in_a) {
    std::size_t i = 0, j = 0;
    for (std::size_t k = 0; k < pooled.size(); ++k) (in_a[k] ? x[i++] : y[j++]) = pooled[k];
    as_large += statistic(x, y) >= observed - slack;
    ++all;
  };
  std::vector<bool> in_a(pooled.size(), false);
  std::fill(in_a.begin(), in_a.begin() + static_cast<std::ptrdiff_t>(a.size()), true);
  if (splits(a.size(), b.size()) <= most_splits) {
    do count(in_a);
    while (std::prev_permutation(in_a.begin(), in_a.end()));
    return static_cast<double>(as_large) / all;
  }
  Dealer dealer;
  std::vector<char> cards(in_a.begin(), in_a.end());
  for (int draw = 0; draw < draws; ++draw) {
    dealer.shuffle(cards);
    count(std::vector<bool>(cards.begin(), cards.end()));
  }
  return (as_large + 1.0) / (all + 1.0);
}

double share_distance(const std::vector<double>& a, const std::vector<double>& b) {
  assert(a.size() == b.size());
  const double all_a = std::accumulate(a.begin(), a.end(), 0.0),
               all_b = std::accumulate(b.begin(), b.end(), 0.0);
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::abs(a[i] / all_a - b[i] / all_b) / 2;
  return sum;
}

double share_p_value(const std::vector<double>& a, const std::vector<double>& b, int draws) {
  const double observed = share_distance(a, b) - 1e-12;
  std::vector<std::size_t> things;  // their classes: those of a first
  std::size_t of_a = 0;
  for (const auto* counts : {&a, &b}) {
    for (std::size_t i = 0; i < counts->size(); ++i)
      things.insert(things.end(), static_cast<std::size_t>(std::llround((*counts)[i])), i);
    if (counts == &a) of_a = things.size();
  }
  Dealer dealer;
  int as_large = 0;
  for (int draw = 0; draw < draws; ++draw) {
    dealer.shuffle(things);
    std::vector<double> x(a.size(), 0), y(a.size(), 0);
    for (std::size_t k = 0; k < things.size(); ++k) (k < of_a ? x : y)[things[k]] += 1;
    as_large += share_distance(x, y) >= observed;
  }
  return (as_large + 1.0) / (draws + 1.0);
}

}  // namespace firn
