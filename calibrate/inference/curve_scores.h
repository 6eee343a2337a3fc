// Curves as targets: their scores on the principal components of the simulated curves (functional
// principal component analysis; Ramsay and Silverman, Functional Data Analysis, chapter 8).
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <vector>

#include "calibrate/study/study_runs.h"

namespace firn {

struct CurveBasis {
  Eigen::VectorXd mean;        // of the simulated curves [places]
  Eigen::MatrixXd components;  // [places, components], each with a mean square of 1
  double explained = 0;        // share of the variance between the curves of different parameters
  // Root mean square of what the components leave: of the mean curves of points, of single runs,
  // which scatter between seeds, and of the recorded curve.
  double simulated_rest = 0, run_rest = 0, recorded_rest = 0;
};

// By the mean curves of the points. As few components as hold 99 % of the variance, and no more
// than the target allows. Nothing where fewer than three points have the curve.
std::optional<CurveBasis> curve_basis(const CurveTarget& target, const std::vector<Point>& points);

// One for each component: the score of the recorded curve. Each score is as uncertain as the curve,
// which holds for errors of any shape, and as what the components leave of the simulated curves.
std::vector<Target> score_targets(const CurveTarget& target, const CurveBasis& basis);

// Adds the scores of a finished run to its responses, where it reaches over all places.
void add_scores(const CurveTarget& target, const CurveBasis& basis, JobResult& run);
void add_scores(const CurveTarget& target, const CurveBasis& basis, Point& point);  // of its runs

// Whether the recorded curve has a part that no simulated one has, beyond its uncertainty and the
// scatter of a single run.
bool has_unexplained_part(const CurveTarget& target, const CurveBasis& basis);

}  // namespace firn
