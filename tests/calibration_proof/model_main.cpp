// How well the response models know their uncertainty, over the problems of a text file
// (problems.toml): models of designs as studies have them, against the exact mean responses at
// random places. Prints a Markdown table.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>

#include "calibrate/inference/response_model.h"
#include "calibrate/numerics/experimental_design.h"
#include "experiments/analysis/random_stream.h"
#include "tests/calibration_proof/covered_problem.h"
#include "tests/support/fake_experiment.h"

namespace firn::proof {
namespace {

using Eigen::VectorXd;

// Errors of many models of one response.
struct ModelTally {
  int count = 0, within_68 = 0, within_95 = 0;
  double z = 0, z2 = 0, error2 = 0, stated2 = 0, score = 0;
};

void judge_model(const CoveredProblem& p, const CoveredResponse& r, int points, int seeds,
                 std::uint64_t seed, ModelTally& t) {
  std::mt19937_64 random(seed);
  const auto d = static_cast<int>(p.parameters.size());
  Study study;
  study.parameters = p.parameters;
  study.targets.push_back({{0, "y", "y"}, 0, 1, "1", "", 0});
  study.experiments.push_back({"", "", {}, std::vector<bool>(p.parameters.size(), true)});
  std::vector<Point> all;
  const auto add = [&](const VectorXd& u, int runs) {
    Point point;
    point.u = u;
    point.results.resize(1);
    for (int i = 0; i < runs; ++i)
      point.results[0].push_back(finished({scalar("y", r.run(values_at(p, u), random), "1")}));
    all.push_back(point);
  };
  add(VectorXd::Constant(d, 0.5), 4);
  for (const VectorXd& u : maximin_latin_hypercube(points, d, seed, {all[0].u})) add(u, seeds);
  const auto models = fit_response_models(study, all);
  if (!models) return;
  for (int i = 0; i < 100; ++i) {
    VectorXd u(d);
    for (double& x : u) x = uniform_open(random);
    const Prediction q = models->targets[0].surrogate.best.predict(u);
    const double error = q.mean - r.mean(values_at(p, u)), error2 = error * error;
    ++t.count;
    t.within_68 += error2 < q.variance;
    t.within_95 += error2 < 1.96 * 1.96 * q.variance;
    t.z += error / std::sqrt(q.variance);
    t.z2 += error2 / q.variance;
    t.error2 += error2 / (r.uncertainty * r.uncertainty);
    t.stated2 += q.variance / (r.uncertainty * r.uncertainty);
    // Of a measurement by its own uncertainty and the model's, relative to that of the exact mean.
    const double v = r.uncertainty * r.uncertainty + q.variance;
    t.score -= 0.5 * (std::log(v / (r.uncertainty * r.uncertainty)) +
                      (r.uncertainty * r.uncertainty + error2) / v - 1);
  }
}

void print_model_row(const std::string& name, const ModelTally& t) {
  const double n = std::max(1, t.count);
  fmt::print("| {} | {:.2f} | {:.2f} | {:.0f} % | {:.0f} % | {:.2f} | {:.2f} | {:.4f} |\n", name,
             std::sqrt(t.z2 / n), t.z / n, 100 * t.within_68 / n, 100 * t.within_95 / n,
             std::sqrt(t.error2 / n), std::sqrt(t.stated2 / n), t.score / n);
  std::fflush(stdout);
}

}  // namespace
}  // namespace firn::proof

int main(int argc, char** argv) {
  using namespace firn::proof;
  CLI::App app("How well do response models know their uncertainty?");
  std::string file;
  int models = 20;
  app.add_option("PROBLEMS.toml", file)->required();
  app.add_option("--models", models, "of each response and design")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    fmt::print(
        "| response, design | error over stated | its mean | within 1 | within 2 | error | stated "
        "| score |\n"
        "|---|---|---|---|---|---|---|---|\n");
    ModelTally all;
    for (const CoveredProblem& p : read_covered_problems(file))
      for (const CoveredResponse& r : p.responses)
        for (const int seeds : {1, 2}) {
          ModelTally t;
          const int points = seeds == 1 ? 26 : 13;
          for (int m = 0; m < models; ++m)
            judge_model(p, r, points, seeds, static_cast<std::uint64_t>(1 + 1000 * m), t);
          print_model_row(fmt::format("{}, {}, {} x {}", p.name, r.name, points, seeds), t);
          for (int ModelTally::*n :
               {&ModelTally::count, &ModelTally::within_68, &ModelTally::within_95})
            all.*n += t.*n;
          for (double ModelTally::*x : {&ModelTally::z, &ModelTally::z2, &ModelTally::error2,
                                        &ModelTally::stated2, &ModelTally::score})
            all.*x += t.*x;
        }
    print_model_row("all", all);
    return 0;
  } catch (const std::exception& e) {
    fmt::print(stderr, "firn: {}\n", e.what());
    return 2;
  }
}
