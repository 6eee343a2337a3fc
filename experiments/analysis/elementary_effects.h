// Screening by elementary effects: which factors change a response, and which do so by curvature or
// interactions. Morris, Technometrics 33 (1991) 161-174; the mean of absolute effects: Campolongo,
// Cariboni and Saltelli, Environ. Model. Softw. 22 (2007) 1509-1518.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace firn {

// Two points that differ in one factor: from a level in the lower half of its levels to the one
// half of the levels above.
struct ScreeningStep {
  std::size_t factor = 0;
  std::size_t lower = 0, upper = 0;  // indices into ScreeningDesign::points
};

struct ScreeningDesign {
  std::vector<std::size_t> levels;                       // [factors] number of levels, even
  std::vector<std::vector<std::size_t>> points;          // [points][factors] level; all different
  std::vector<std::vector<ScreeningStep>> trajectories;  // each has one step of each factor
};

// Random trajectories, the same for the same seed on every machine. Each begins at a random point
// and changes the factors one after the other, in random order. `levels`: at least one factor,
// even numbers.
ScreeningDesign screening_design(const std::vector<std::size_t>& levels, int trajectories,
                                 std::uint64_t seed);

// Elementary effects of one factor on one response, in units of the response: its change over the
// step, scaled to the whole range of the factor.
struct ElementaryEffects {
  int count = 0;                  // trajectories in which both ends are defined
  double mean = 0;                // mu: with sign; NaN for no effect
  double mean_absolute = 0;       // mu*: the importance of the factor; NaN for no effect
  double standard_deviation = 0;  // sigma: curvature, interactions and noise; NaN below two
  // 95 % interval of mean_absolute over trajectories, by Student's distribution, not below 0; NaN
  // below two.
  double lower = 0, upper = 0;
};

// [factors], for the response `y` [points]; NaN: undefined there.
std::vector<ElementaryEffects> elementary_effects(const ScreeningDesign& design,
                                                  std::span<const double> y);

// Mean absolute effect [factors] that noise alone gives if the response does not depend on a
// factor. `standard_error`: of the response at a point.
std::vector<double> noise_effects(const ScreeningDesign& design, double standard_error);

}  // namespace firn
