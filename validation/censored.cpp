// Times of which some are only known to be longer.
#include <algorithm>
#include <cmath>

#include "validation/statistics.h"

namespace firn {
namespace {

// So many of a sample stay in at least until x, and so many pass at x.
double at_risk(const CensoredTimes& t, double x) {
  const auto later = [&](double v) { return v >= x; };
  return static_cast<double>(std::ranges::count_if(t.passed, later) +
                             std::ranges::count_if(t.inside, later));
}
double passing(const CensoredTimes& t, double x) {
  return static_cast<double>(std::ranges::count(t.passed, x));
}

std::vector<double> distinct(std::vector<double> values) {
  std::ranges::sort(values);
  values.erase(std::unique(values.begin(), values.end()), values.end());
  return values;
}

// Both kinds in one list of positive numbers and their negatives, as permutations need it.
std::vector<double> signed_times(const CensoredTimes& t) {
  std::vector<double> all = t.passed;
  for (const double v : t.inside) all.push_back(-v);
  return all;
}
CensoredTimes from_signed(const std::vector<double>& all) {
  CensoredTimes t;
  for (const double v : all) (std::signbit(v) ? t.inside : t.passed).push_back(std::abs(v));
  return t;
}

}  // namespace

PassedShare kaplan_meier(const CensoredTimes& times) {
  PassedShare s;
  s.x = distinct(times.passed);
  double inside = 1, sum = 0;  // Greenwood's
  for (const double x : s.x) {
    const double n = at_risk(times, x), d = passing(times, x);
    inside *= 1 - d / n;
    sum += n > d ? d / (n * (n - d)) : 0;
    s.share.push_back(1 - inside);
    s.error.push_back(inside * std::sqrt(sum));
  }
  return s;
}

double passed_distance(const PassedShare& a, const PassedShare& b) {
  if (a.x.empty() || b.x.empty()) return 0;
  const auto at = [](const PassedShare& s, double x) {
    const auto next = std::ranges::upper_bound(s.x, x);
    return next == s.x.begin() ? 0.0 : s.share[static_cast<std::size_t>(next - s.x.begin()) - 1];
  };
  const double reach = std::min(a.x.back(), b.x.back());
  double largest = 0;
  for (const PassedShare* s : {&a, &b})
    for (const double x : s->x)
      if (x <= reach) largest = std::max(largest, std::abs(at(a, x) - at(b, x)));
  return largest;
}

double passed_p_value(const CensoredTimes& a, const CensoredTimes& b, int draws) {
  const auto statistic = [](const std::vector<double>& x, const std::vector<double>& y) {
    return passed_distance(kaplan_meier(from_signed(x)), kaplan_meier(from_signed(y)));
  };
  return permutation_p_value(signed_times(a), signed_times(b), statistic, draws);
}

}  // namespace firn
