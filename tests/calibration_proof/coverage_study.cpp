#include "tests/calibration_proof/coverage_study.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <random>

#include "calibrate/inference/goodness_of_fit.h"
#include "calibrate/inference/posterior.h"
#include "experiments/analysis/random_stream.h"
#include "experiments/storage/sha256.h"

namespace firn::proof {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using nlohmann::json;

// Minus twice the logarithm of the likelihood with the exact mean responses.
double exact_cost(const CoveredProblem& p, const std::vector<double>& target, const VectorXd& u) {
  const std::vector<double> v = values_at(p, u);
  double cost = 0;
  for (std::size_t k = 0; k < target.size(); ++k)
    cost += std::pow((p.responses[k].mean(v) - target[k]) / p.responses[k].uncertainty, 2);
  return cost;
}

// Standard deviation of a parameter over that of a uniform distribution over its range.
double ideal_width(const Posterior& ideal, Index parameter) {
  double mean = 0, square = 0;
  for (std::size_t s = 0; s < ideal.u.size(); ++s) mean += ideal.weight[s] * ideal.u[s][parameter];
  for (std::size_t s = 0; s < ideal.u.size(); ++s)
    square += ideal.weight[s] * std::pow(ideal.u[s][parameter] - mean, 2);
  return std::sqrt(12 * square);
}

void judge_parameters(const json& results, const std::vector<double>& truth, const Posterior& ideal,
                      CoverageOutcome& o) {
  double log_width = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const json& q = results["parameters"][i];
    log_width += std::log(q["posterior_to_prior_sd"].get<double>() /
                          ideal_width(ideal, static_cast<Index>(i)));
    o.intervals += q["interval_95"][0].get<double>() <= truth[i] &&
                   truth[i] <= q["interval_95"][1].get<double>();
    ++o.parameters;
  }
  o.width = std::exp(log_width / static_cast<double>(truth.size()));
}

void judge_combinations(const CoveredProblem& p, const json& results,
                        const std::vector<double>& truth, CoverageOutcome& o) {
  for (const json& c : results["combinations"]) {
    if (!c["identifiable"].get<bool>()) continue;
    double at_truth = 0;
    for (std::size_t i = 0; i < truth.size(); ++i)
      at_truth += c["terms"][i]["coefficient"].get<double>() *
                  (p.parameters[i].logarithmic ? std::log(truth[i]) : truth[i]);
    ++o.determined;
    o.far_off += std::abs(at_truth - c["value"].get<double>()) > 2 * c["uncertainty"].get<double>();
  }
}

void judge_models(const CoveredProblem& p, const json& fit, const std::vector<double>& truth,
                  CoverageOutcome& o) {
  for (const CoveredResponse& r : p.responses) {
    const json& q = fit[r.name];
    o.model_z.push_back((q["value"].get<double>() - r.mean(truth)) /
                        q["uncertainty"].get<double>());
  }
}

void judge_confirmation(const CoveredProblem& p, const json& estimate, CoverageOutcome& o) {
  std::vector<double> answer;
  for (std::size_t i = 0; i < p.parameters.size(); ++i)
    answer.push_back(estimate["parameters"]["p" + std::to_string(i)].get<double>());
  for (const CoveredResponse& r : p.responses) {
    const json& q = estimate["simulated"][r.name];
    if (q["value"].is_null() || !(q["standard_error"].get<double>() > 0)) continue;
    o.confirmed_z.push_back((q["value"].get<double>() - r.mean(answer)) /
                            q["standard_error"].get<double>());
  }
}

}  // namespace

StudyDraw draw_study(const CoveredProblem& p, const std::string& where, int index) {
  const std::uint64_t of_row = std::stoull(sha256(p.name + where).substr(0, 15), nullptr, 16);
  std::mt19937_64 random(of_row + static_cast<std::uint64_t>(index));
  StudyDraw d;
  d.u = draw_truth(p, where, random);
  d.truth = values_at(p, d.u);
  for (const CoveredResponse& r : p.responses)
    d.target.push_back(r.mean(d.truth) + r.uncertainty * normal_deviate(random));
  // The noise of a run depends on its seed and its parameters: equal seeds would correlate studies
  // of different rows.
  d.seed = 1 + static_cast<int>(random() % 1'000'000'000);
  return d;
}

CoverageOutcome cover(const CoveredProblem& p, const std::string& where, int index, int runs) {
  const StudyDraw d = draw_study(p, where, index);
  const json results = solve_covered(p, d.truth, d.target, runs, d.seed);
  CoverageOutcome o;
  o.verdict = results["verdict"].get<std::string>();
  o.cautions = static_cast<int>(results["cautions"].size());
  o.cost = results["wall_seconds"].get<double>();
  const json& compared = results["compare"][0];
  if (!compared.contains("hpd_level")) return o;
  o.level = compared["hpd_level"].get<double>();
  const auto exact = [&](const VectorXd& u) { return exact_cost(p, d.target, u); };
  const Posterior ideal = sample_density(exact, static_cast<int>(d.truth.size()));
  o.ideal_level = ideal.hpd_level(exact(d.u));
  // At the best of the samples.
  const double least = *std::min_element(ideal.cost.begin(), ideal.cost.end());
  const double freedom = results["goodness_of_fit"]["degrees_of_freedom"].get<double>();
  o.ideal_infeasible = chi_square_tail(least, freedom) < 0.05;
  judge_parameters(results, d.truth, ideal, o);
  judge_combinations(p, results, d.truth, o);
  judge_models(p, compared["fit"], d.truth, o);
  if (results.contains("estimate")) judge_confirmation(p, results["estimate"], o);
  return o;
}

}  // namespace firn::proof
