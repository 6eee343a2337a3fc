// Recorded curves that simulated ones have to reproduce, such as force over time.
#pragma once

#include <Eigen/Dense>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace firn {

struct JobResult;

struct CurveTarget {
  std::size_t experiment = 0;
  std::string name;   // of the [[measure]]: the responses NAME_curve_x and NAME_curve_y
  std::string label;  // for people: the name, behind that of its experiment where there are several
  std::string x_unit, unit;
  Eigen::VectorXd x, y;    // recorded, mean of the repeats at evenly spaced places where all reach
  double uncertainty = 0;  // root mean square over the places of the error of y, > 0
  double discrepancy = 0;  // as of a target, of each score
  int components = 0;      // at most
  std::string source, file;
};

// y at `places` on straight lines between samples in any order; nothing where they do not reach
// over all places.
std::optional<Eigen::VectorXd> sampled_curve(const std::vector<double>& x,
                                             const std::vector<double>& y,
                                             const Eigen::VectorXd& places);

// y of a finished run at the places and in the units of the target; nothing where the run does not
// reach over all of them. Throws InputError (one sentence) for a run without this curve or with
// units of another kind.
std::optional<Eigen::VectorXd> simulated_curve(const CurveTarget& target, const JobResult& run);

}  // namespace firn
