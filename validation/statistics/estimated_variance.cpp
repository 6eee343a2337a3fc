#include "validation/statistics/estimated_variance.h"

#include <algorithm>
#include <array>
#include <boost/math/distributions/chi_squared.hpp>
#include <cassert>
#include <cmath>
#include <map>
#include <mutex>

namespace firn {
namespace {

constexpr std::size_t points = 1024;
constexpr std::array<int, 12> primes = {2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37};

// Halton's sequence: the k-th point, in (0, 1), of the dimension with this base.
double halton(std::size_t k, int base) {
  double sum = 0, digit = 1;
  for (std::size_t i = k + 1; i > 0; i /= static_cast<std::size_t>(base)) {
    digit /= base;
    sum += digit * static_cast<double>(i % static_cast<std::size_t>(base));
  }
  return sum;
}

// Quantiles of f / chi2(f) at the points of one dimension. Computed once for each f: a validation
// uses a few of them many times.
std::vector<double> inverse_quantiles(double freedom, int base) {
  static std::mutex guard;
  static std::map<std::pair<double, int>, std::vector<double>> known;
  const std::lock_guard lock(guard);
  if (known.size() > 1000) known.clear();
  std::vector<double>& q = known[{freedom, base}];
  if (!q.empty()) return q;
  const boost::math::chi_squared distribution(freedom);
  for (std::size_t k = 0; k < points; ++k)
    q.push_back(freedom / boost::math::quantile(distribution, halton(k, base)));
  return q;
}

double total(const Noise& noise, const std::vector<double>& estimates) {
  double sum = 0;
  for (const Noise::Term& term : noise.terms) {
    double part = 0;
    for (const auto& [index, coefficient] : term) part += coefficient * estimates[index];
    sum += std::max(0.0, part);
  }
  return sum;
}

// The total variance at each point of the sequence.
std::vector<double> variances(const Noise& noise) {
  assert(noise.estimates.size() <= primes.size());
  std::vector<std::vector<double>> by_point(points, std::vector<double>(noise.estimates.size()));
  for (std::size_t j = 0; j < noise.estimates.size(); ++j) {
    const EstimatedVariance& e = noise.estimates[j];
    if (!std::isfinite(e.freedom) || e.value == 0) {
      for (auto& p : by_point) p[j] = e.value;
      continue;
    }
    const std::vector<double> factors = inverse_quantiles(e.freedom, primes[j]);
    for (std::size_t k = 0; k < points; ++k) by_point[k][j] = e.value * factors[k];
  }
  std::vector<double> all;
  all.reserve(points);
  for (const auto& p : by_point) all.push_back(total(noise, p));
  return all;
}

double exceedance(const std::vector<double>& variances, double size) {
  double sum = 0;
  for (const double v : variances)
    sum += v > 0 ? std::erfc(size / std::sqrt(2 * v)) : (size > 0 ? 0 : 1);
  return sum / static_cast<double>(variances.size());
}

}  // namespace

std::size_t Noise::add(EstimatedVariance estimate, double coefficient) {
  estimates.push_back(estimate);
  terms.push_back({{estimates.size() - 1, coefficient}});
  return estimates.size() - 1;
}

double Noise::variance() const {
  std::vector<double> values;
  for (const EstimatedVariance& e : estimates) values.push_back(e.value);
  return total(*this, values);
}

double exceedance(const Noise& noise, double size) { return exceedance(variances(noise), size); }

double expanded_uncertainty(const Noise& noise, double confidence) {
  const std::vector<double> all = variances(noise);
  const double most = *std::ranges::max_element(all);
  if (!(most > 0)) return 0;
  double low = 0, high = std::sqrt(most) * 10;
  for (int i = 0; i < 100 && high - low > 1e-9 * high; ++i) {
    const double mid = (low + high) / 2;
    (exceedance(all, mid) > 1 - confidence ? low : high) = mid;
  }
  return high;
}

}  // namespace firn
