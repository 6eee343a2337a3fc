#include "calibrate/numerics/optimize.h"

#include <ceres/ceres.h>
#include <ceres/gradient_checker.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <nlopt.hpp>

namespace firn {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Stands between NLopt and the objective: NaN would stop NLopt for good, and BOBYQA steps an ulp
// outside its bounds.
class Guard {
 public:
  Guard(const std::function<double(const VectorXd&)>& f, const VectorXd& lower,
        const VectorXd& upper, int most = std::numeric_limits<int>::max())
      : f_(f), lower_(lower), upper_(upper), most_(most) {}

  static double call(const std::vector<double>& x, std::vector<double>&, void* self) {
    auto* guard = static_cast<Guard*>(self);
    // Random searches check NLopt's limit only at intervals.
    if (guard->best_.evaluations >= guard->most_) throw nlopt::forced_stop();
    try {
      return guard->evaluate(x);
    } catch (...) {  // NLopt would lose it
      guard->thrown_ = std::current_exception();
      throw nlopt::forced_stop();
    }
  }

  void rethrow() const {
    if (thrown_) std::rethrow_exception(thrown_);
  }

  double evaluate(const std::vector<double>& raw) {
    const VectorXd x = Eigen::Map<const VectorXd>(raw.data(), static_cast<Eigen::Index>(raw.size()))
                           .cwiseMax(lower_)
                           .cwiseMin(upper_);
    ++best_.evaluations;
    const double value = f_(x);
    if (!std::isfinite(value)) {
      ++best_.non_finite;
      return std::isfinite(worst_) ? worst_ + 0.1 * std::abs(worst_) + 1 : 1e6;
    }
    worst_ = std::isfinite(worst_) ? std::max(worst_, value) : value;
    if (best_.x.size() == 0 || value < best_.value) {
      best_.x = x;
      best_.value = value;
    }
    return value;
  }

  // The best seen is the answer whatever way the search ended.
  const Minimum& best() const { return best_; }

 private:
  const std::function<double(const VectorXd&)>& f_;
  const VectorXd &lower_, &upper_;
  int most_;
  double worst_ = -std::numeric_limits<double>::infinity();
  Minimum best_;
  std::exception_ptr thrown_;
};

std::vector<double> to_std(const VectorXd& v) { return {v.data(), v.data() + v.size()}; }

void search(Guard& guard, nlopt::opt& opt, const VectorXd& lower, const VectorXd& upper,
            const VectorXd& start) {
  opt.set_lower_bounds(to_std(lower));
  opt.set_upper_bounds(to_std(upper));
  opt.set_min_objective(&Guard::call, &guard);
  std::vector<double> x = to_std(start);
  double value = 0;
  try {
    opt.optimize(x, value);
  } catch (const nlopt::roundoff_limited&) {
    // As near as doubles allow: what was found stands.
  } catch (const nlopt::forced_stop&) {
    guard.rethrow();
  }
}

void local_search(Guard& guard, const VectorXd& lower, const VectorXd& upper, const VectorXd& start,
                  double step, int evaluations) {
  // BOBYQA is for two dimensions and more.
  nlopt::opt opt(start.size() == 1 ? nlopt::LN_SBPLX : nlopt::LN_BOBYQA,
                 static_cast<unsigned>(start.size()));
  opt.set_maxeval(evaluations);
  opt.set_xtol_abs(1e-9 * (upper - lower).maxCoeff());
  opt.set_initial_step(to_std(step * (upper - lower)));
  search(guard, opt, lower, upper, start.cwiseMax(lower).cwiseMin(upper));
}

class CeresAdapter final : public ceres::CostFunction {
 public:
  CeresAdapter(const LeastSquaresProblem& problem, int parameters) : problem_(problem) {
    mutable_parameter_block_sizes()->push_back(parameters);
    set_num_residuals(problem.residuals);
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const Eigen::Index n = parameter_block_sizes()[0], m = num_residuals();
    const VectorXd x = Eigen::Map<const VectorXd>(parameters[0], n);
    const bool wanted = jacobians != nullptr && jacobians[0] != nullptr;
    VectorXd r(m);
    MatrixXd jacobian(m, n);
    if (!problem_.evaluate(x, r, wanted ? &jacobian : nullptr)) return false;
    if (!r.allFinite() || (wanted && !jacobian.allFinite())) return false;
    Eigen::Map<VectorXd>(residuals, m) = r;
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    if (wanted) Eigen::Map<RowMajor>(jacobians[0], m, n) = jacobian;
    return true;
  }

 private:
  const LeastSquaresProblem& problem_;
};

}  // namespace

Minimum minimize(const std::function<double(const VectorXd&)>& f, const VectorXd& lower,
                 const VectorXd& upper, int evaluations) {
  Guard guard(f, lower, upper);
  nlopt::opt opt(nlopt::GN_DIRECT_L, static_cast<unsigned>(lower.size()));
  opt.set_maxeval(evaluations);
  search(guard, opt, lower, upper, 0.5 * (lower + upper));
  if (guard.best().x.size() > 0) {
    const VectorXd start = guard.best().x;
    local_search(guard, lower, upper, start, 0.05, evaluations);
  }
  return guard.best();
}

Minimum minimize_locally(const std::function<double(const VectorXd&)>& f, const VectorXd& lower,
                         const VectorXd& upper, const VectorXd& start, double step,
                         int evaluations) {
  Guard guard(f, lower, upper);
  local_search(guard, lower, upper, start, step, evaluations);
  return guard.best();
}

Minimum search_directly(const std::function<double(const VectorXd&)>& f, const VectorXd& lower,
                        const VectorXd& upper, DirectSearch search, int evaluations,
                        std::uint64_t seed) {
  const auto algorithm = [&] {
    switch (search) {
      case DirectSearch::bobyqa:
        return lower.size() == 1 ? nlopt::LN_SBPLX : nlopt::LN_BOBYQA;
      case DirectSearch::cobyla:
        return nlopt::LN_COBYLA;
      case DirectSearch::nelder_mead:
        return nlopt::LN_NELDERMEAD;
      default:
        return nlopt::GN_CRS2_LM;
    }
  }();
  Guard guard(f, lower, upper, evaluations);
  nlopt::srand(static_cast<unsigned long>(seed));
  nlopt::opt opt(algorithm, static_cast<unsigned>(lower.size()));
  opt.set_maxeval(evaluations);
  opt.set_xtol_abs(1e-2 * (upper - lower).maxCoeff());
  opt.set_initial_step(to_std(0.2 * (upper - lower)));
  firn::search(guard, opt, lower, upper, 0.5 * (lower + upper));
  return guard.best();
}

LeastSquaresFit least_squares(const LeastSquaresProblem& problem, const VectorXd& start) {
  LeastSquaresFit fit;
  fit.x = start;
  ceres::Problem ceres_problem;
  // Ceres owns the adapter.
  ceres_problem.AddResidualBlock(new CeresAdapter(problem, static_cast<int>(start.size())), nullptr,
                                 fit.x.data());
  for (int i = 0; i < problem.lower.size(); ++i) {
    ceres_problem.SetParameterLowerBound(fit.x.data(), i, problem.lower[i]);
    ceres_problem.SetParameterUpperBound(fit.x.data(), i, problem.upper[i]);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.num_threads = 1;
  options.max_num_iterations = 500;
  options.function_tolerance = 1e-15;
  options.gradient_tolerance = 1e-12;
  options.parameter_tolerance = 1e-13;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &ceres_problem, &summary);
  fit.converged = summary.termination_type == ceres::CONVERGENCE;
  fit.message = summary.message;
  fit.sum_of_squares = 2 * summary.final_cost;
  fit.jacobian.resize(problem.residuals, start.size());
  VectorXd r(problem.residuals);
  if (!problem.evaluate(fit.x, r, &fit.jacobian)) fit.converged = false;
  return fit;
}

double jacobian_error(const LeastSquaresProblem& problem, const VectorXd& x, double step) {
  CeresAdapter adapter(problem, static_cast<int>(x.size()));
  ceres::NumericDiffOptions numeric;
  numeric.ridders_relative_initial_step_size = step;
  const std::vector<const ceres::Manifold*>* no_manifolds = nullptr;
  ceres::GradientChecker checker(&adapter, no_manifolds, numeric);
  const double* blocks[] = {x.data()};
  ceres::GradientChecker::ProbeResults results;
  checker.Probe(blocks, 1e-9, &results);
  return results.maximum_relative_error;
}

}  // namespace firn
