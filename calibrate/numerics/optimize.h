// The two searches of the calibration: NLopt for the global minimum, Ceres for least squares.
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <functional>
#include <string>

namespace firn {

struct Minimum {
  Eigen::VectorXd x;
  double value = 0;
  int evaluations = 0;
  int non_finite = 0;  // evaluations that were not a number, kept from the search
};

// Global minimum of f over the box [lower, upper]: DIRECT-L, then BOBYQA from its best point.
// Deterministic. f may return NaN or infinity where it has no value; such points count as worse
// than the worst value so far.
Minimum minimize(const std::function<double(const Eigen::VectorXd&)>& f,
                 const Eigen::VectorXd& lower, const Eigen::VectorXd& upper, int evaluations);
// BOBYQA alone, from `start` with first steps of `step` times the box.
Minimum minimize_locally(const std::function<double(const Eigen::VectorXd&)>& f,
                         const Eigen::VectorXd& lower, const Eigen::VectorXd& upper,
                         const Eigen::VectorXd& start, double step, int evaluations);

// Searches that use only values of f: local ones from the middle of the box with first steps of a
// fifth of it, or a controlled random search (its population of ten per dimension and ten more is
// drawn from `seed`). Steps below a hundredth of the box end a local search. Deterministic.
// Exceptions of f pass through.
enum class DirectSearch { none, bobyqa, cobyla, nelder_mead, crs };
Minimum search_directly(const std::function<double(const Eigen::VectorXd&)>& f,
                        const Eigen::VectorXd& lower, const Eigen::VectorXd& upper,
                        DirectSearch search, int evaluations, std::uint64_t seed);

struct LeastSquaresProblem {
  int residuals = 0;
  // Residuals at x and, when asked for, their Jacobian [residuals, parameters]. False: no value
  // there.
  std::function<bool(const Eigen::VectorXd& x, Eigen::VectorXd& r, Eigen::MatrixXd* jacobian)>
      evaluate;
  Eigen::VectorXd lower, upper;  // empty: no bounds
};

struct LeastSquaresFit {
  Eigen::VectorXd x;
  double sum_of_squares = 0;
  Eigen::MatrixXd jacobian;  // at x
  bool converged = false;
  std::string message;
};

// Levenberg-Marquardt from `start`.
LeastSquaresFit least_squares(const LeastSquaresProblem& problem, const Eigen::VectorXd& start);

// Largest relative difference between the problem's Jacobian and Ceres's own numeric one at x; for
// tests of hand-written derivatives. `step` is where Ridders' extrapolation starts, relative to
// each parameter and absolute at the least: it must not exceed a small parameter.
double jacobian_error(const LeastSquaresProblem& problem, const Eigen::VectorXd& x,
                      double step = 1e-2);

}  // namespace firn
