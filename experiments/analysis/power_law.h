// y ~ x^p through means and their standard errors: what a sweep over a stiffness says, and what a
// validation makes of a reduced one.
#pragma once

#include <limits>
#include <span>

namespace firn {

struct PowerLaw {
  double exponent = 0;
  // Half-width of the interval that holds the exponent with 68 %, by Student's distribution: a
  // standard error, wider when few runs determine the scatter. NaN: two points, which give a
  // slope but no measure of its error.
  double exponent_error = std::numeric_limits<double>::quiet_NaN();

  struct Logarithm {
    double value = 0, error = 0;  // of ln(y), standard error; the error is NaN as above
  };
  Logarithm at(double x) const;

  // The line: ln(y) = height + exponent (ln(x) - centre), with standard errors.
  double centre = 0, height = 0, height_error = 0, slope_error = 0;
  double degrees_of_freedom = 0;  // of the errors; 0: they are not known
};

// Whether a power law can be put through points: x and mean above zero at two different x or more.
bool has_power_law(std::span<const double> x, std::span<const double> mean);

// Half-width of a two-sided interval of Student's distribution, in standard errors.
double student_factor(double degrees_of_freedom, double confidence = 0.95);

// Weighted least squares of ln(mean) over ln(x). `error`: standard errors of the means, NaN where
// not known; `runs`: how many a mean is of. The relative scatter of a run is taken as the same at
// every x and pooled over all, since two or three runs cannot determine it; each mean counts as
// known to 2 % at best. A line that misses by more than that scatter explains (F-test, 5 %) is no
// better known than it misses. Points as for has_power_law().
PowerLaw fit_power_law(std::span<const double> x, std::span<const double> mean,
                       std::span<const double> error, std::span<const int> runs);

}  // namespace firn
