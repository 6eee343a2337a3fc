// Fit of y ~ x^p to means with standard errors: for responses over a varied stiffness.
#pragma once

#include <limits>
#include <span>

namespace firn {

struct PowerLaw {
  double exponent = 0;
  // Half-width of the 68 % interval of the exponent by Student's distribution: wider than the
  // standard error if few runs determine the scatter. NaN: unknown, e.g. for two points.
  double exponent_error = std::numeric_limits<double>::quiet_NaN();

  struct Logarithm {
    double value = 0, error = 0;  // ln(y) and its standard error; NaN as above
  };
  Logarithm at(double x) const;  // x > 0

  // ln(y) = log_mean + exponent (ln(x) - center), with standard errors.
  double center = 0, log_mean = 0, log_mean_error = 0, slope_error = 0;
  double degrees_of_freedom = 0;  // of the errors; 0: unknown
};

// Whether a power law can be fitted: all x and means above 0, and at least two different x.
bool has_power_law(std::span<const double> x, std::span<const double> mean);

// Weighted least squares of ln(mean) over ln(x). `error`: standard errors of the means, NaN:
// unknown. `runs`: number of runs of each mean. The relative scatter of a run is assumed equal at
// all x and is pooled, since two or three runs do not determine it. A relative error of 2 % is
// added to each mean in quadrature. If the residuals exceed the scatter significantly (F-test, 5
// %), the errors are scaled to the residuals. Requires has_power_law().
PowerLaw fit_power_law(std::span<const double> x, std::span<const double> mean,
                       std::span<const double> error, std::span<const int> runs);

}  // namespace firn
