// Methods of calibration on the same problems of a text file (problems.toml): Firn, CMA-ES on the
// mean, restarts of BOBYQA on the mean, and a Latin hypercube with a quadratic. Prints Markdown
// tables: the distance from the targets for a number of runs, coverage, and behavior under misfit.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <optional>

#include "calibrate/inference/goodness_of_fit.h"
#include "calibrate/inference/posterior.h"
#include "calibrate/numerics/experimental_design.h"
#include "calibrate/numerics/optimize.h"
#include "experiments/analysis/random_stream.h"
#include "experiments/analysis/sample_statistics.h"
#include "experiments/storage/sha256.h"
#include "tests/calibration_proof/covered_problem.h"
#include "tests/support/fake_experiment.h"

namespace firn::proof {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using nlohmann::json;

// A study of one problem: its truth, what was measured of it, and the runs that a method makes.
struct Laboratory {
  const CoveredProblem& problem;
  std::vector<double> truth, target;
  std::uint64_t seed = 1;
  std::mt19937_64 random{1};

  Index dimensions() const { return static_cast<Index>(problem.parameters.size()); }
  // Distance of so many runs' mean from the targets, in standard deviations of the measurements
  // (root mean square).
  double simulated_distance(const VectorXd& u, int replicates) {
    const std::vector<double> v = values_at(problem, u);
    double sum = 0;
    for (std::size_t k = 0; k < target.size(); ++k) {
      double mean = 0;
      for (int i = 0; i < replicates; ++i) mean += problem.responses[k].run(v, random) / replicates;
      sum += std::pow((mean - target[k]) / problem.responses[k].uncertainty, 2);
    }
    return std::sqrt(sum / static_cast<double>(target.size()));
  }
  double true_distance(const std::vector<double>& v) const {
    double sum = 0;
    for (std::size_t k = 0; k < target.size(); ++k)
      sum += std::pow((problem.responses[k].mean(v) - target[k]) / problem.responses[k].uncertainty,
                      2);
    return std::sqrt(sum / static_cast<double>(target.size()));
  }
};

// What a method says at its end.
struct MethodAnswer {
  std::vector<double> values;
  std::optional<bool> region;     // holds the truth; nothing: the method states none
  int inside = 0, intervals = 0;  // of the stated 95 % intervals, those that hold the truth
  std::optional<bool> misfit;     // says that the targets are not met; nothing: it has no test
};

MethodAnswer by_firn(Laboratory& lab, int runs) {
  const json j =
      solve_covered(lab.problem, lab.truth, lab.target, runs, static_cast<int>(lab.seed % 100000));
  MethodAnswer a;
  a.misfit = j["verdict"] == "infeasible" || j["verdict"] == "unconfirmed";
  for (std::size_t i = 0; i < lab.truth.size(); ++i) {
    a.values.push_back(j["estimate"]["parameters"]["p" + std::to_string(i)]);
    const json& q = j["parameters"][i]["interval_95"];
    a.inside += q[0] <= lab.truth[i] && lab.truth[i] <= q[1];
    ++a.intervals;
  }
  a.region = j["compare"][0]["hpd_level"].get<double>() <= 0.95;
  return a;
}

// Least squares of a quadratic polynomial of one response, with the variance of its mean.
class Quadratic {
 public:
  Quadratic(const std::vector<VectorXd>& u, const VectorXd& y) {
    const Index n = y.size(), terms = basis(u.front()).size();
    MatrixXd h(n, terms);
    for (Index i = 0; i < n; ++i) h.row(i) = basis(u[static_cast<std::size_t>(i)]).transpose();
    const Eigen::ColPivHouseholderQR<MatrixXd> qr(h);
    coefficients_ = qr.solve(y);
    const double left = (y - h * coefficients_).squaredNorm();
    covariance_ = (h.transpose() * h).ldlt().solve(MatrixXd::Identity(terms, terms)) * left /
                  static_cast<double>(std::max<Index>(1, n - terms));
  }
  double mean(const VectorXd& u) const { return basis(u).dot(coefficients_); }
  double variance(const VectorXd& u) const {
    const VectorXd h = basis(u);
    const VectorXd spread = covariance_ * h;
    return h.dot(spread);
  }
  static Index terms(Index d) { return basis(VectorXd::Zero(d)).size(); }

 private:
  static VectorXd basis(const VectorXd& u) {
    const Index d = u.size();
    VectorXd h(1 + d + d * (d + 1) / 2);
    h[0] = 1;
    h.segment(1, d) = u;
    for (Index i = 0, k = 1 + d; i < d; ++i)
      for (Index j = i; j < d; ++j) h[k++] = u[i] * u[j];
    return h;
  }
  VectorXd coefficients_;
  MatrixXd covariance_;
};

// One run at each point of a Latin hypercube. Region and intervals as of Firn's posterior, with the
// polynomials for the responses.
MethodAnswer by_quadratic(Laboratory& lab, int runs) {
  const Index d = lab.dimensions();
  const std::vector<VectorXd> u =
      maximin_latin_hypercube(runs, static_cast<int>(d), lab.seed, std::vector<VectorXd>{});
  std::vector<Quadratic> models;
  for (const CoveredResponse& r : lab.problem.responses) {
    VectorXd y(runs);
    for (Index i = 0; i < runs; ++i)
      y[i] = r.run(values_at(lab.problem, u[static_cast<std::size_t>(i)]), lab.random);
    models.emplace_back(u, y);
  }
  const auto squares = [&](const VectorXd& x, bool with_logarithm) {
    double sum = 0;
    for (std::size_t k = 0; k < models.size(); ++k) {
      const double v = std::pow(lab.problem.responses[k].uncertainty, 2) + models[k].variance(x);
      sum +=
          std::pow(models[k].mean(x) - lab.target[k], 2) / v + (with_logarithm ? std::log(v) : 0);
    }
    return sum;
  };
  const std::function<double(const VectorXd&)> cost = [&](const VectorXd& x) {
    return squares(x, true);
  };
  const Minimum best = minimize(cost, VectorXd::Zero(d), VectorXd::Ones(d), 600);
  const Posterior posterior = sample_density(cost, static_cast<int>(d));
  VectorXd truth_u(d);
  for (Index i = 0; i < d; ++i)
    truth_u[i] = lab.problem.parameters[static_cast<std::size_t>(i)].to_unit(
        lab.truth[static_cast<std::size_t>(i)]);
  MethodAnswer a;
  a.values = values_at(lab.problem, best.x);
  a.region = posterior.hpd_level(cost(truth_u)) <= 0.95;
  for (Index i = 0; i < d; ++i) {
    std::vector<double> x;
    for (const VectorXd& sample : posterior.u) x.push_back(sample[i]);
    a.inside += weighted_quantile(x, posterior.weight, 0.025) <= truth_u[i] &&
                truth_u[i] <= weighted_quantile(x, posterior.weight, 0.975);
    ++a.intervals;
  }
  const double freedom = std::max(1.0, static_cast<double>(models.size()) - static_cast<double>(d));
  a.misfit = chi_square_tail(squares(best.x, false), freedom) < 0.05;
  return a;
}

constexpr int mean_of = 2;  // replicates of an evaluation of a search

// CMA-ES (Hansen, The CMA evolution strategy: a tutorial, 2016) in the unit cube; points beyond it
// are moved onto it.
class CmaEs {
 public:
  explicit CmaEs(Index d)
      : n_(static_cast<double>(d)),
        lambda_(4 + static_cast<int>(3 * std::log(n_))),
        parents_(lambda_ / 2),
        weights_(parents_),
        mean_(VectorXd::Constant(d, 0.5)),
        path_(VectorXd::Zero(d)),
        step_path_(path_),
        covariance_(MatrixXd::Identity(d, d)) {
    for (int i = 0; i < parents_; ++i)
      weights_[i] = std::log((lambda_ + 1) / 2.0) - std::log(i + 1.0);
    weights_ /= weights_.sum();
    effective_ = 1 / weights_.squaredNorm();
    c_sigma_ = (effective_ + 2) / (n_ + effective_ + 5);
    damping_ = 1 + 2 * std::max(0.0, std::sqrt((effective_ - 1) / (n_ + 1)) - 1) + c_sigma_;
    c_path_ = (4 + effective_ / n_) / (n_ + 4 + 2 * effective_ / n_);
    c_one_ = 2 / ((n_ + 1.3) * (n_ + 1.3) + effective_);
    c_mu_ = std::min(1 - c_one_,
                     2 * (effective_ - 2 + 1 / effective_) / ((n_ + 2) * (n_ + 2) + effective_));
    normal_length_ = std::sqrt(n_) * (1 - 1 / (4 * n_) + 1 / (21 * n_ * n_));
  }

  int evaluations() const { return lambda_ * mean_of; }  // of a generation
  const VectorXd& mean() const { return mean_; }
  // So many standard deviations of the distribution.
  double half_width(double factor, Index i) const {
    return factor * sigma_ * std::sqrt(covariance_(i, i));
  }

  void next_generation(Laboratory& lab) {
    ++generation_;
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(covariance_);
    const VectorXd roots = eigen.eigenvalues().cwiseMax(1e-20).cwiseSqrt();
    const Children children = drawn_children(lab, eigen.eigenvectors(), roots);
    const VectorXd before = mean_;
    mean_.setZero();
    for (int i = 0; i < parents_; ++i)
      mean_ += weights_[i] * children[static_cast<std::size_t>(i)].second;
    const VectorXd step = (mean_ - before) / sigma_;
    const VectorXd whitened =
        eigen.eigenvectors() * (eigen.eigenvectors().transpose() * step).cwiseQuotient(roots);
    const bool moving = follow(step, whitened);
    adapt(children, before, moving);
  }

 private:
  using Children = std::vector<std::pair<double, VectorXd>>;  // distance and place, best first

  Children drawn_children(Laboratory& lab, const MatrixXd& axes, const VectorXd& roots) const {
    Children children;
    for (int i = 0; i < lambda_; ++i) {
      VectorXd z(mean_.size());
      for (double& x : z) x = normal_deviate(lab.random);
      const VectorXd u = (mean_ + sigma_ * (axes * roots.cwiseProduct(z))).cwiseMax(0).cwiseMin(1);
      children.emplace_back(lab.simulated_distance(u, mean_of), u);
    }
    std::sort(children.begin(), children.end(),
              [](const auto& a, const auto& b) { return a.first < b.first; });
    return children;
  }

  // Updates the evolution paths. False where the step path is too long for the path to follow.
  bool follow(const VectorXd& step, const VectorXd& whitened) {
    step_path_ =
        (1 - c_sigma_) * step_path_ + std::sqrt(c_sigma_ * (2 - c_sigma_) * effective_) * whitened;
    const bool moving =
        step_path_.norm() / std::sqrt(1 - std::pow(1 - c_sigma_, 2.0 * generation_)) <
        (1.4 + 2 / (n_ + 1)) * normal_length_;
    path_ = (1 - c_path_) * path_ +
            (moving ? std::sqrt(c_path_ * (2 - c_path_) * effective_) : 0.0) * step;
    return moving;
  }

  // Updates the covariance and the step length.
  void adapt(const Children& children, const VectorXd& before, bool moving) {
    MatrixXd ranks = MatrixXd::Zero(mean_.size(), mean_.size());
    for (int i = 0; i < parents_; ++i) {
      const VectorXd y = (children[static_cast<std::size_t>(i)].second - before) / sigma_;
      ranks += weights_[i] * y * y.transpose();
    }
    covariance_ =
        (1 - c_one_ - c_mu_ + (moving ? 0.0 : c_one_ * c_path_ * (2 - c_path_))) * covariance_ +
        c_one_ * path_ * path_.transpose() + c_mu_ * ranks;
    sigma_ = std::min(
        1.0, sigma_ * std::exp(c_sigma_ / damping_ * (step_path_.norm() / normal_length_ - 1)));
  }

  double n_;  // parameters
  int lambda_, parents_, generation_ = 0;
  VectorXd weights_;
  double effective_ = 0, c_sigma_ = 0, damping_ = 0, c_path_ = 0, c_one_ = 0, c_mu_ = 0;
  double normal_length_ = 0;  // of a standard normal vector, in the mean
  VectorXd mean_, path_, step_path_;
  MatrixXd covariance_;
  double sigma_ = 0.3;
};

// The answer is the mean of the last distribution, and the stated interval two of its standard
// deviations, as of an uncertainty read off the last generation.
MethodAnswer by_cma_es(Laboratory& lab, int runs) {
  const Index d = lab.dimensions();
  CmaEs search(d);
  for (int left = runs; left >= search.evaluations(); left -= search.evaluations())
    search.next_generation(lab);
  MethodAnswer a;
  a.values = values_at(lab.problem, search.mean());
  for (Index i = 0; i < d; ++i) {
    const double u = lab.problem.parameters[static_cast<std::size_t>(i)].to_unit(
        lab.truth[static_cast<std::size_t>(i)]);
    a.inside += std::abs(u - search.mean()[i]) <= search.half_width(1.96, i);
    ++a.intervals;
  }
  return a;
}

// BOBYQA from the middle and then from random places, until the runs are used; the best that it
// saw.
MethodAnswer by_restarts(Laboratory& lab, int runs) {
  const Index d = lab.dimensions();
  double least = std::numeric_limits<double>::infinity();
  VectorXd best = VectorXd::Constant(d, 0.5), start = best;
  for (int left = runs / mean_of; left >= 2 * d + 2;) {
    const auto seen = [&](const VectorXd& u) {
      --left;
      const double distance = lab.simulated_distance(u, mean_of);
      if (distance < least) {
        least = distance;
        best = u;
      }
      return distance * distance;
    };
    minimize_locally(seen, VectorXd::Zero(d), VectorXd::Ones(d), start, 0.2, left);
    for (double& x : start) x = uniform_open(lab.random);
  }
  MethodAnswer a;
  a.values = values_at(lab.problem, best);
  return a;
}

struct Method {
  std::string name;
  std::function<MethodAnswer(Laboratory&, int)> answer;
  std::vector<int> ladder;  // numbers of runs that are tried
};

Laboratory laboratory(const CoveredProblem& p, int study, double errors, double shift) {
  const std::uint64_t base = std::stoull(sha256(p.name + "compared").substr(0, 12), nullptr, 16);
  Laboratory lab{p, {}, {}, base + static_cast<std::uint64_t>(study), std::mt19937_64{1}};
  std::mt19937_64 random(lab.seed);
  lab.truth = values_at(p, draw_truth(p, "prior", random));
  for (const CoveredResponse& r : p.responses)
    lab.target.push_back(r.mean(lab.truth) + errors * r.uncertainty * normal_deviate(random));
  // The first target is too large by so many standard deviations.
  lab.target[0] += shift * p.responses[0].uncertainty;
  lab.random.seed(lab.seed + 77);
  return lab;
}

double median_of(std::vector<double> x) {
  std::sort(x.begin(), x.end());
  return x[x.size() / 2];
}

void accuracy_table(const std::vector<const CoveredProblem*>& problems,
                    const std::vector<Method>& methods, int studies) {
  fmt::print("| problem |");
  for (const Method& m : methods) fmt::print(" {} |", m.name);
  fmt::print("\n|---|");
  for (std::size_t i = 0; i < methods.size(); ++i) fmt::print("---|");
  fmt::print("\n");
  for (const CoveredProblem* p : problems) {
    fmt::print("| {} |", p->name);
    for (const Method& m : methods) {
      std::vector<std::string> cells;
      for (const int runs : m.ladder) {
        if (m.name != "Firn" &&
            runs < Quadratic::terms(static_cast<Index>(p->parameters.size())) + 2)
          continue;
        std::vector<double> distances;
        for (int s = 0; s < studies; ++s) {
          Laboratory lab = laboratory(*p, s, 0, 0);
          distances.push_back(lab.true_distance(m.answer(lab, runs).values));
        }
        cells.push_back(fmt::format("{}: {:.2f}", runs, median_of(distances)));
      }
      fmt::print(" {} |", fmt::join(cells, ", "));
      std::fflush(stdout);
    }
    fmt::print("\n");
  }
}

void coverage_table(const std::vector<const CoveredProblem*>& problems,
                    const std::vector<Method>& methods, int studies, int runs, double shift) {
  fmt::print(
      "\n| problem | method | 95 % region | 95 % intervals | says that the targets are not met |\n"
      "|---|---|---|---|---|\n");
  for (const CoveredProblem* p : problems)
    for (const Method& m : methods) {
      int regions = 0, inside = 0, intervals = 0, misfits = 0;
      bool states_region = true, states_misfit = true;
      for (int s = 0; s < studies; ++s) {
        Laboratory lab = laboratory(*p, s, 1, shift);
        const MethodAnswer a = m.answer(lab, runs);
        states_region = states_region && a.region.has_value();
        states_misfit = states_misfit && a.misfit.has_value();
        regions += a.region.value_or(false);
        misfits += a.misfit.value_or(false);
        inside += a.inside;
        intervals += a.intervals;
      }
      const auto share = [](bool stated, int part, int of) {
        return stated && of > 0 ? fmt::format("{} of {}", part, of) : std::string("states none");
      };
      fmt::print("| {} | {} | {} | {} | {} |\n", p->name, m.name,
                 share(states_region, regions, studies), share(true, inside, intervals),
                 share(states_misfit, misfits, studies));
      std::fflush(stdout);
    }
}

}  // namespace
}  // namespace firn::proof

int main(int argc, char** argv) {
  using namespace firn::proof;
  CLI::App app("Firn next to other methods, on the same problems.");
  std::string file;
  int studies = 20, runs = 40;
  std::vector<std::string> names = {"heap and flow", "two lines that cross",
                                    "curved valley", "steep exponential",
                                    "kink",          "three parameters, three targets"};
  app.add_option("PROBLEMS.toml", file)->required();
  app.add_option("--studies", studies, "for each cell of a table")->capture_default_str();
  app.add_option("--runs", runs, "of each study of coverage and misfit")->capture_default_str();
  app.add_option("--problem", names, "of these names");
  CLI11_PARSE(app, argc, argv);
  try {
    const std::vector<CoveredProblem> all = read_covered_problems(file);
    std::vector<const CoveredProblem*> problems, overdetermined;
    for (const CoveredProblem& p : all) {
      if (std::find(names.begin(), names.end(), p.name) != names.end()) problems.push_back(&p);
      if (p.responses.size() > p.parameters.size()) overdetermined.push_back(&p);
    }
    const std::vector<int> many = {20, 40, 80, 160, 320};
    const std::vector<Method> methods = {{"Firn", by_firn, {20, 40, 80}},
                                         {"CMA-ES on the mean", by_cma_es, many},
                                         {"BOBYQA with restarts", by_restarts, many},
                                         {"Latin hypercube, quadratic", by_quadratic, many}};
    fmt::print("## Distance from the targets\n\n");
    accuracy_table(problems, methods, studies);
    fmt::print("\n## Coverage\n");
    coverage_table(problems, methods, studies, runs, 0);
    fmt::print("\n## One target wrong by six standard deviations\n");
    coverage_table(overdetermined, methods, studies, runs, 6);
    return 0;
  } catch (const std::exception& e) {
    fmt::print(stderr, "firn: {}\n", e.what());
    return 2;
  }
}
