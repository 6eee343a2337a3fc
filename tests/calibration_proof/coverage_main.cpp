// Coverage of the calibration over the problems of a text file (problems.toml): how often regions
// and intervals hold the truth, how wide they are relative to the posterior with the exact
// responses, and whether stated errors are right. Prints a Markdown table.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "calibrate/inference/goodness_of_fit.h"
#include "calibrate/inference/posterior.h"
#include "experiments/storage/sha256.h"
#include "tests/calibration_proof/covered_problem.h"
#include "tests/support/fake_experiment.h"

namespace firn::proof {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using nlohmann::json;
using Values = std::vector<double>;

struct CoverageCounts {
  int studies = 0, region_95 = 0, region_68 = 0, ideal_95 = 0, ideal_68 = 0, intervals = 0;
  int parameters = 0, infeasible = 0, ideal_infeasible = 0, unconfirmed = 0, confirmed_values = 0;
  int combinations = 0, far_off = 0, predictions = 0, confirmed_far_off = 0;
  double log_width = 0, confirmed_z2 = 0, model_z2 = 0, cost = 0;
};

void judge_study(const CoveredProblem& p, const VectorXd& truth_u, const Values& truth,
                 const std::vector<double>& target, const json& j, CoverageCounts& t) {
  ++t.studies;
  t.cost += j["wall_seconds"].get<double>();
  t.infeasible += j["verdict"] == "infeasible";
  t.unconfirmed += j["verdict"] == "unconfirmed";
  const json& compared = j["compare"][0];
  if (!compared.contains("hpd_level")) return;
  const double hpd_level = compared["hpd_level"];
  t.region_95 += hpd_level <= 0.95;
  t.region_68 += hpd_level <= 0.68;
  const auto exact = [&](const VectorXd& u) {
    double cost = 0;
    const Values v = values_at(p, u);
    for (std::size_t k = 0; k < target.size(); ++k)
      cost += std::pow((p.responses[k].mean(v) - target[k]) / p.responses[k].uncertainty, 2);
    return cost;
  };
  const Posterior ideal = sample_density(exact, static_cast<int>(truth.size()));
  const double ideal_level = ideal.hpd_level(exact(truth_u));
  t.ideal_95 += ideal_level <= 0.95;
  t.ideal_68 += ideal_level <= 0.68;
  // The same test of fit with the exact responses, at the best of the samples.
  const double least = *std::min_element(ideal.cost.begin(), ideal.cost.end());
  t.ideal_infeasible +=
      chi_square_tail(least, j["goodness_of_fit"]["degrees_of_freedom"].get<double>()) < 0.05;
  for (const CoveredResponse& r : p.responses) {
    const json& fit = compared["fit"][r.name];
    t.model_z2 += std::pow(
        (fit["value"].get<double>() - r.mean(truth)) / fit["uncertainty"].get<double>(), 2);
    ++t.predictions;
  }
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const json& q = j["parameters"][i];
    double mean = 0, square = 0;
    for (std::size_t s = 0; s < ideal.u.size(); ++s)
      mean += ideal.weight[s] * ideal.u[s][static_cast<Index>(i)];
    for (std::size_t s = 0; s < ideal.u.size(); ++s)
      square += ideal.weight[s] * std::pow(ideal.u[s][static_cast<Index>(i)] - mean, 2);
    t.log_width += std::log(q["posterior_to_prior_sd"].get<double>() / std::sqrt(12 * square));
    t.intervals += q["interval_95"][0] <= truth[i] && truth[i] <= q["interval_95"][1];
    ++t.parameters;
  }
  for (const json& c : j["combinations"]) {
    if (!c["identifiable"]) continue;
    double at_truth = 0;
    for (std::size_t i = 0; i < truth.size(); ++i)
      at_truth += c["terms"][i]["coefficient"].get<double>() *
                  (p.parameters[i].logarithmic ? std::log(truth[i]) : truth[i]);
    ++t.combinations;
    t.far_off += std::abs(at_truth - c["value"].get<double>()) > 2 * c["uncertainty"].get<double>();
  }
  if (!j.contains("estimate")) return;
  Values answer;
  for (std::size_t i = 0; i < truth.size(); ++i)
    answer.push_back(j["estimate"]["parameters"]["p" + std::to_string(i)]);
  for (const CoveredResponse& r : p.responses) {
    const json& o = j["estimate"]["simulated"][r.name];
    if (o["value"].is_null() || !(o["standard_error"].get<double>() > 0)) continue;
    const double z =
        (o["value"].get<double>() - r.mean(answer)) / o["standard_error"].get<double>();
    t.confirmed_z2 += z * z;
    t.confirmed_far_off += std::abs(z) > 2;
    ++t.confirmed_values;
  }
}

CoverageCounts cover(const CoveredProblem& p, const std::string& where, int studies, int runs) {
  CoverageCounts t;
  const std::uint64_t of_problem = std::stoull(sha256(p.name + where).substr(0, 15), nullptr, 16);
  for (int s = 0; s < studies; ++s) {
    std::mt19937_64 random(of_problem + static_cast<std::uint64_t>(s));
    const VectorXd u = draw_truth(p, where, random);
    const Values truth = values_at(p, u);
    std::vector<double> target;
    for (const CoveredResponse& r : p.responses)
      target.push_back(r.mean(truth) + r.uncertainty * normal_deviate(random));
    judge_study(p, u, truth, target, solve_covered(p, truth, target, runs, 1 + 10000 * s), t);
  }
  return t;
}

void print_row(const std::string& name, const CoverageCounts& t) {
  const auto share = [](int part, int of) {
    return of == 0 ? std::string("-") : fmt::format("{:.0f} %", 100.0 * part / of);
  };
  const auto ratio = [](double z2, int of) { return std::sqrt(z2 / std::max(1, of)); };
  fmt::print(
      "| {} | {} | {} | {} | {} | {} | {} | {:.2f} | {} of {} | {} ({}) | {} | {:.2f} | "
      "{} of {} | {:.2f} | {:.0f} |\n",
      name, t.studies, share(t.region_95, t.studies), share(t.ideal_95, t.studies),
      share(t.region_68, t.studies), share(t.ideal_68, t.studies), share(t.intervals, t.parameters),
      std::exp(t.log_width / std::max(1, t.parameters)), t.far_off, t.combinations, t.infeasible,
      t.ideal_infeasible, t.unconfirmed, ratio(t.confirmed_z2, t.confirmed_values),
      t.confirmed_far_off, t.confirmed_values, ratio(t.model_z2, t.predictions),
      t.cost / std::max(1, t.studies));
  std::fflush(stdout);
}

void add(CoverageCounts& sum, const CoverageCounts& t) {
  for (int CoverageCounts::*n :
       {&CoverageCounts::studies, &CoverageCounts::region_95, &CoverageCounts::region_68,
        &CoverageCounts::ideal_95, &CoverageCounts::ideal_68, &CoverageCounts::intervals,
        &CoverageCounts::parameters, &CoverageCounts::infeasible, &CoverageCounts::ideal_infeasible,
        &CoverageCounts::unconfirmed, &CoverageCounts::confirmed_values,
        &CoverageCounts::combinations, &CoverageCounts::far_off, &CoverageCounts::predictions,
        &CoverageCounts::confirmed_far_off})
    sum.*n += t.*n;
  for (double CoverageCounts::*x : {&CoverageCounts::log_width, &CoverageCounts::confirmed_z2,
                                    &CoverageCounts::model_z2, &CoverageCounts::cost})
    sum.*x += t.*x;
}

// Chance of at most so many successes of so many tries.
double chance_of_so_few(int inside, int count, double share) {
  double sum = 0;
  for (int k = 0; k <= inside; ++k)
    sum += std::exp(std::lgamma(count + 1) - std::lgamma(k + 1) - std::lgamma(count - k + 1) +
                    k * std::log(share) + (count - k) * std::log(1 - share));
  return sum;
}

}  // namespace
}  // namespace firn::proof

int main(int argc, char** argv) {
  using namespace firn::proof;
  CLI::App app("How often do regions and intervals hold the truth?");
  std::string file, only;
  int studies = 10, runs = 40, from = 0, to = 1000;
  app.add_option("PROBLEMS.toml", file)->required();
  app.add_option("--studies", studies, "for each problem and place of the truth")
      ->capture_default_str();
  app.add_option("--runs", runs, "of each study")->capture_default_str();
  app.add_option("--problem", only, "of this name alone");
  app.add_option("--from", from, "first problem, by number")->capture_default_str();
  app.add_option("--to", to, "last problem, by number")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    const std::vector<CoveredProblem> problems = read_covered_problems(file);
    fmt::print(
        "| problem, truth | studies | 95 % region | of the ideal | 68 % region | of the ideal | "
        "95 % intervals | width over ideal | determined off by > 2u | infeasible (ideal) | "
        "unconfirmed | confirmed error over stated | off by > 2 sd | model error over stated | "
        "cost |\n"
        "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
    CoverageCounts all;
    for (int i = from; i < static_cast<int>(problems.size()) && i <= to; ++i) {
      const CoveredProblem& p = problems[static_cast<std::size_t>(i)];
      if (!only.empty() && p.name != only) continue;
      for (const std::string& where : p.truths) {
        const CoverageCounts t = cover(p, where, studies, runs);
        print_row(p.name + ", " + where, t);
        add(all, t);
      }
    }
    print_row("all", all);
    // The engine may be conservative; more misses than chance explains once in a thousand is a
    // broken promise.
    return chance_of_so_few(all.region_95, all.studies, 0.90) < 0.001 ? 1 : 0;
  } catch (const std::exception& e) {
    fmt::print(stderr, "firn: {}\n", e.what());
    return 2;
  }
}
