// Which form of surrogate explains the data best.
#include <cmath>

#include "calibrate/numerics/surrogate.h"

namespace firn {

SurrogateChoice choose_surrogate(const SurrogateData& data) {
  // A process with a length for each parameter needs more points than a polynomial.
  const bool enough_for_matern = data.y.size() >= 3 * data.u.cols() + 1;
  constexpr double least_of_logarithm = 1e-30;  // the square of one below it may vanish
  const bool positive = data.y.minCoeff() > least_of_logarithm;
  std::vector<Surrogate> candidates;
  for (const bool logarithm : {false, true}) {
    if (logarithm && !positive) continue;
    candidates.emplace_back(data, SurrogateForm{false, false, logarithm});
    candidates.emplace_back(data, SurrogateForm{true, false, logarithm});
    if (enough_for_matern) candidates.emplace_back(data, SurrogateForm{false, true, logarithm});
  }
  // A difference of half a unit of log density is negligible: the earlier, simpler form is kept.
  constexpr double near_tie = 0.5;
  const auto pick = [&](auto&& allowed) {
    const Surrogate* best = nullptr;
    for (const Surrogate& s : candidates)
      if (allowed(s.form()) &&
          (best == nullptr || s.leave_one_out_score() > best->leave_one_out_score() + near_tie))
        best = &s;
    return best;
  };
  const Surrogate* best = pick([](const SurrogateForm&) { return true; });
  const Surrogate* other = pick([&](const SurrogateForm& f) {
    return f.matern != best->form().matern || f.quadratic != best->form().quadratic;
  });
  // Weights by predictive density (pseudo Bayesian model averaging).
  constexpr double negligible = 0.02;
  const double share =
      1 / (1 + std::exp(best->leave_one_out_score() - other->leave_one_out_score()));
  return {share > negligible ? best->mixed_with(*other, share) : *best, *other};
}

}  // namespace firn
