// The noise of a difference whose variance is only estimated: its distribution and its interval.
// Pure functions.
#pragma once

#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

namespace firn {

// A variance and the degrees of freedom that it was estimated with (infinite: it is known).
struct EstimatedVariance {
  double value = 0;
  double freedom = std::numeric_limits<double>::infinity();
};

// Normal noise with the variance sum over the terms of max(0, sum of coefficient * estimate).
// A term with a negative coefficient is a component that is estimated by a difference, as the
// scatter of draws less that of seeds.
struct Noise {
  using Term = std::vector<std::pair<std::size_t, double>>;  // (index of an estimate, coefficient)
  std::vector<EstimatedVariance> estimates;
  std::vector<Term> terms;

  // Adds coefficient * estimate as a term; returns the index of the estimate.
  std::size_t add(EstimatedVariance estimate, double coefficient = 1);
  double variance() const;  // at the estimates
};

// Probability that the noise exceeds `size` (>= 0) in magnitude. Each estimate v with f degrees of
// freedom stands for v f / chi2(f) (generalized inference, Weerahandi 1993): Student's distribution
// for one estimate, and near the nominal level for several of few degrees of freedom each.
double exceedance(const Noise& noise, double size);

// Bound of the magnitude of the noise with this confidence. Zero for no noise.
double expanded_uncertainty(const Noise& noise, double confidence = 0.95);

}  // namespace firn
