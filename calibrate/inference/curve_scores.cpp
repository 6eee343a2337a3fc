#include "calibrate/inference/curve_scores.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace firn {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double enough = 0.99;  // of the variance
constexpr std::size_t least_points = 3;

std::string score_name(const std::string& curve, Index k) {
  return fmt::format("{}.score_{}", curve, k + 1);
}

VectorXd scores(const CurveBasis& basis, const VectorXd& y) {
  return basis.components.transpose() * (y - basis.mean) / static_cast<double>(y.size());
}

double mean_square_rest(const CurveBasis& basis, const VectorXd& y) {
  return (y - basis.mean - basis.components * scores(basis, y)).squaredNorm() /
         static_cast<double>(y.size());
}

// Of the finished runs of a point that reach over all places.
std::vector<VectorXd> curves_of_runs(const CurveTarget& target, const Point& point) {
  std::vector<VectorXd> curves;
  if (target.experiment >= point.results.size()) return curves;
  for (const JobResult& run : point.results[target.experiment])
    if (run.status == JobStatus::finished)
      if (auto y = simulated_curve(target, run)) curves.push_back(std::move(*y));
  return curves;
}

VectorXd mean_of(const std::vector<VectorXd>& curves) {
  VectorXd mean = VectorXd::Zero(curves.front().size());
  for (const VectorXd& y : curves) mean += y / static_cast<double>(curves.size());
  return mean;
}

// Root mean square of what the components leave of some curves.
double rest_of(const CurveBasis& basis, const std::vector<VectorXd>& curves) {
  double sum = 0;
  for (const VectorXd& y : curves)
    sum += mean_square_rest(basis, y) / static_cast<double>(curves.size());
  return std::sqrt(sum);
}

}  // namespace

std::optional<CurveBasis> curve_basis(const CurveTarget& target, const std::vector<Point>& points) {
  std::vector<VectorXd> curves, runs;
  for (const Point& p : points) {
    if (p.u.minCoeff() < 0 || p.u.maxCoeff() > 1) continue;
    const std::vector<VectorXd> here = curves_of_runs(target, p);
    if (here.empty()) continue;
    curves.push_back(mean_of(here));
    runs.insert(runs.end(), here.begin(), here.end());
  }
  if (curves.size() < least_points) return std::nullopt;
  const auto n = static_cast<Index>(curves.size()), places = target.x.size();
  CurveBasis basis;
  basis.mean = mean_of(curves);
  MatrixXd off(n, places);
  for (Index i = 0; i < n; ++i)
    off.row(i) = (curves[static_cast<std::size_t>(i)] - basis.mean).transpose();
  const Eigen::JacobiSVD<MatrixXd> svd(off, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const VectorXd variance = svd.singularValues().cwiseAbs2();
  const double all = variance.sum();
  const Index most = std::min<Index>(target.components, n - 2);
  Index count = 1;
  while (count < most && variance.head(count).sum() < enough * all) ++count;
  basis.components = std::sqrt(static_cast<double>(places)) * svd.matrixV().leftCols(count);
  for (Index k = 0; k < count; ++k) {
    Index largest = 0;
    basis.components.col(k).cwiseAbs().maxCoeff(&largest);
    if (basis.components(largest, k) < 0) basis.components.col(k) *= -1;
  }
  basis.explained = all > 0 ? variance.head(count).sum() / all : 1;
  basis.simulated_rest = rest_of(basis, curves);
  basis.run_rest = rest_of(basis, runs);
  basis.recorded_rest = rest_of(basis, {target.y});
  return basis;
}

std::vector<Target> score_targets(const CurveTarget& target, const CurveBasis& basis) {
  const VectorXd recorded = scores(basis, target.y);
  std::vector<Target> all;
  for (Index k = 0; k < recorded.size(); ++k) {
    Target t;
    t.response = {target.experiment, score_name(target.name, k), score_name(target.label, k)};
    t.value = recorded[k];
    t.uncertainty = std::hypot(target.uncertainty, basis.simulated_rest);
    t.unit = target.unit;
    t.source = fmt::format("score {} of {} of the curve {}: {}", k + 1, recorded.size(),
                           target.name, target.source);
    t.file = target.file;
    t.discrepancy = target.discrepancy;
    all.push_back(std::move(t));
  }
  return all;
}

void add_scores(const CurveTarget& target, const CurveBasis& basis, JobResult& run) {
  if (run.status != JobStatus::finished) return;
  const auto y = simulated_curve(target, run);
  if (!y) return;
  const VectorXd s = scores(basis, *y);
  for (Index k = 0; k < s.size(); ++k)
    run.responses.push_back({score_name(target.name, k),
                             {s[k]},
                             {},
                             target.unit,
                             "score on a principal component of the simulated curves",
                             1});
}

void add_scores(const CurveTarget& target, const CurveBasis& basis, Point& point) {
  if (target.experiment >= point.results.size()) return;
  for (JobResult& run : point.results[target.experiment]) add_scores(target, basis, run);
}

bool has_unexplained_part(const CurveTarget& target, const CurveBasis& basis) {
  constexpr double clearly = 2;
  return basis.recorded_rest >
         clearly * std::sqrt(std::pow(target.uncertainty, 2) + std::pow(target.discrepancy, 2) +
                             std::pow(basis.run_rest, 2));
}

}  // namespace firn
