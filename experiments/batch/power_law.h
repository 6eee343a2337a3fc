// y ~ x^p through means and their standard errors: what a sweep over a stiffness says, and what a
// validation makes of a reduced one.
#pragma once

#include <limits>
#include <span>

namespace firn {

struct PowerLaw {
  double exponent = 0;
  // Standard error. NaN: of two points, which give a slope and no idea of how straight it is.
  double exponent_error = std::numeric_limits<double>::quiet_NaN();

  struct Logarithm {
    double value = 0, error = 0;  // of ln(y); the error is NaN as above
  };
  Logarithm at(double x) const;

  // The line: ln(y) = height + exponent (ln(x) - centre), height_error that at the centre.
  double centre = 0, height = 0, height_error = 0;
  int degrees_of_freedom = 0;
};

// Whether a power law can be put through points: x and mean above zero at two different x or more.
bool has_power_law(std::span<const double> x, std::span<const double> mean);

// Weighted least squares of ln(mean) over ln(x). `error`: standard errors of the means, NaN where
// not known; each counts as 2 % at least, as few runs may happen to agree. A line that misses by
// more than the errors say is no better known than it misses. Points as has_power_law wants them.
PowerLaw fit_power_law(std::span<const double> x, std::span<const double> mean,
                       std::span<const double> error);

}  // namespace firn
