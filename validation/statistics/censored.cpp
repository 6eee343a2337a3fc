// Times of which some are only known to be longer.
#include <algorithm>
#include <cmath>

#include "validation/statistics/distributions.h"

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

}  // namespace

EmpiricalCdf kaplan_meier(const CensoredTimes& times) {
  EmpiricalCdf s;
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

}  // namespace firn
