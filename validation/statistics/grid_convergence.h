// Numerical uncertainty from three levels of refinement. Pure functions.
#pragma once

#include <optional>
#include <string>

namespace firn {

// A result on three levels with a constant refinement ratio, and the standard error of the
// difference of the two finer ones (with shared seeds, the remaining random part).
struct Levels {
  double coarse = 0, medium = 0, fine = 0;
  double ratio = 2;  // of steps, above 1
  double error = 0;
};

struct Convergence {
  std::optional<double> order;  // observed; nothing where scatter or oscillation hides it
  double uncertainty = 0;       // one standard deviation, of the coarse result
  std::string how;
};

// Where the differences exceed the scatter and decrease by a ratio, the observed order p (Roache
// 1994): the coarse result deviates by (coarse - fine) / (1 - ratio^(-2p)), with a factor of safety
// of 1.25 for p between 0.5 and 2.5, else of 3 with p cut to these (grid convergence index), as an
// interval of 95 %. Elsewhere a bound: the largest difference between levels, or twice the error
// where that is more.
Convergence converge(const Levels& levels);

}  // namespace firn
