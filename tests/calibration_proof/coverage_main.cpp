// Coverage of the calibration over the problems of a text file (problems.toml): how often regions
// and intervals hold the truth, how wide they are relative to the posterior with the exact
// responses, and whether stated errors are right. Prints a Markdown table.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "calibrate/inference/posterior.h"
#include "calibrate/numerics/random.h"
#include "experiments/storage/sha256.h"
#include "experiments/system/input_file.h"
#include "experiments/system/input_limits.h"
#include "experiments/text/toml_document.h"
#include "tests/calibration_proof/formula.h"
#include "tests/calibration_proof/problems.h"

namespace firn::proof {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using nlohmann::json;
using Values = std::vector<double>;

// A response with its own scatter: normal noise, and a shift in some of the runs.
struct CoveredResponse {
  std::string name;
  double uncertainty = 0;
  Formula value, noise, shift, shift_share;
  double mean(const Values& v) const { return value(v) + shift(v) * shift_share(v); }
};

struct CoveredProblem {
  std::string name;
  std::vector<Parameter> parameters;
  std::vector<CoveredResponse> responses;
  std::vector<std::string> truths;  // "prior", "border", "corner"
};

CoveredProblem read_problem(const TomlTable& t) {
  t.allow({"name", "truths", "parameters", "responses"});
  CoveredProblem p;
  p.name = t.string("name");
  p.truths = t.strings("truths");
  if (p.truths.empty()) p.truths = {"prior"};
  for (const std::string& truth : p.truths)
    if (truth != "prior" && truth != "border" && truth != "corner")
      t.fail("truths", "has another word; expected some of prior, border, corner");
  std::vector<std::string> names;
  for (const TomlTable& q : t.tables("parameters")) {
    q.allow({"name", "min", "max", "scale"});
    Parameter a;
    a.name = q.string("name");
    a.min = q.number("min");
    a.max = q.number("max");
    a.logarithmic = q.choice("scale", {"linear", "log"}, "linear") == "log";
    names.push_back(a.name);
    p.parameters.push_back(a);
  }
  for (const TomlTable& q : t.tables("responses")) {
    q.allow({"name", "value", "uncertainty", "noise", "shift", "shift_share"});
    const auto formula = [&](const char* key, const std::string& otherwise) {
      return q.at(key, [&] { return parse_formula(q.string(key, otherwise), names); });
    };
    p.responses.push_back({q.string("name"), q.number("uncertainty"),
                           q.at("value", [&] { return parse_formula(q.string("value"), names); }),
                           formula("noise", "0"), formula("shift", "0"),
                           formula("shift_share", "0")});
  }
  if (p.parameters.empty() || p.responses.empty())
    t.fail("", "has no parameters or no responses; expected both");
  return p;
}

std::vector<CoveredProblem> read_problems(const std::string& file) {
  TomlDocument document(
      read_input_file(file, "a file of coverage problems (TOML)", input_limits::toml_bytes), file);
  const TomlTable root = TomlTable::root(document);
  root.allow({"problems"});
  std::vector<CoveredProblem> all;
  for (const TomlTable& t : root.tables("problems")) all.push_back(read_problem(t));
  return all;
}

VectorXd draw_truth(const CoveredProblem& p, const std::string& where, std::mt19937_64& random) {
  VectorXd u(static_cast<Index>(p.parameters.size()));
  const auto end = [&] { return uniform(random) < 0.5 ? 0.0 : 1.0; };
  for (double& x : u) x = where == "corner" ? end() : uniform(random);
  if (where == "border")
    u[static_cast<Index>(random() % static_cast<std::uint64_t>(u.size()))] = end();
  return u;
}

Values values_at(const CoveredProblem& p, const VectorXd& u) {
  Values v;
  for (std::size_t i = 0; i < p.parameters.size(); ++i)
    v.push_back(std::clamp(p.parameters[i].from_unit(u[static_cast<Index>(i)]), p.parameters[i].min,
                           p.parameters[i].max));
  return v;
}

// The study as problems.h writes it: with parameters p0, p1, ...
json solve(const CoveredProblem& p, const Values& truth, const std::vector<double>& target,
           int runs, int seed) {
  Problem plain;
  for (const Parameter& a : p.parameters) plain.parameters.push_back({a.min, a.max, a.logarithmic});
  plain.truth = truth;
  for (const CoveredResponse& r : p.responses)
    plain.responses.push_back({r.name, r.uncertainty, 0, {}});
  FakeExperiment experiment([&](const FakeExperiment::Values& keys, std::mt19937_64& random) {
    const Values v = plain.values(keys);
    std::vector<Response> all;
    for (const CoveredResponse& r : p.responses) {
      const double noise = r.noise(v) * normal(random);
      const double shift = uniform(random) < r.shift_share(v) ? r.shift(v) : 0;
      all.push_back(scalar(r.name, r.value(v) + noise + shift, "1"));
    }
    return finished(all);
  });
  const Folder folder("coverage");
  const std::string file = folder.write("study.toml", study_text(plain, target, runs, seed));
  return json::parse(run_study(file, folder / "out", experiment).json);
}

struct Tally {
  int studies = 0, region_95 = 0, region_68 = 0, ideal_95 = 0, intervals = 0, parameters = 0;
  int infeasible = 0, unconfirmed = 0, confirmed_values = 0, combinations = 0, far_off = 0;
  double log_width = 0, confirmed_z2 = 0;
};

void judge_study(const CoveredProblem& p, const VectorXd& truth_u, const Values& truth,
                 const std::vector<double>& target, const json& j, Tally& t) {
  ++t.studies;
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
  t.ideal_95 += ideal.hpd_level(exact(truth_u)) <= 0.95;
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
    t.confirmed_z2 += std::pow(
        (o["value"].get<double>() - r.mean(answer)) / o["standard_error"].get<double>(), 2);
    ++t.confirmed_values;
  }
}

Tally cover(const CoveredProblem& p, const std::string& where, int studies, int runs) {
  Tally t;
  const std::uint64_t of_problem = std::stoull(sha256(p.name + where).substr(0, 15), nullptr, 16);
  for (int s = 0; s < studies; ++s) {
    std::mt19937_64 random(of_problem + static_cast<std::uint64_t>(s));
    const VectorXd u = draw_truth(p, where, random);
    const Values truth = values_at(p, u);
    std::vector<double> target;
    for (const CoveredResponse& r : p.responses)
      target.push_back(r.mean(truth) + r.uncertainty * normal(random));
    judge_study(p, u, truth, target, solve(p, truth, target, runs, 1 + 10000 * s), t);
  }
  return t;
}

void print_row(const std::string& name, const Tally& t) {
  const auto share = [](int part, int of) {
    return of == 0 ? std::string("-") : fmt::format("{:.0f} %", 100.0 * part / of);
  };
  fmt::print("| {} | {} | {} | {} | {} | {} | {:.2f} | {} of {} | {} | {} | {:.2f} |\n", name,
             t.studies, share(t.region_95, t.studies), share(t.ideal_95, t.studies),
             share(t.region_68, t.studies), share(t.intervals, t.parameters),
             std::exp(t.log_width / std::max(1, t.parameters)), t.far_off, t.combinations,
             t.infeasible, t.unconfirmed,
             std::sqrt(t.confirmed_z2 / std::max(1, t.confirmed_values)));
  std::fflush(stdout);
}

void add(Tally& sum, const Tally& t) {
  for (int Tally::*n :
       {&Tally::studies, &Tally::region_95, &Tally::region_68, &Tally::ideal_95, &Tally::intervals,
        &Tally::parameters, &Tally::infeasible, &Tally::unconfirmed, &Tally::confirmed_values,
        &Tally::combinations, &Tally::far_off})
    sum.*n += t.*n;
  sum.log_width += t.log_width;
  sum.confirmed_z2 += t.confirmed_z2;
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
    const std::vector<CoveredProblem> problems = read_problems(file);
    fmt::print(
        "| problem, truth | studies | 95 % region | of the ideal | 68 % region | 95 % intervals | "
        "width over ideal | determined off by > 2u | infeasible | unconfirmed | confirmed "
        "error over stated |\n|---|---|---|---|---|---|---|---|---|---|---|\n");
    Tally all;
    for (int i = from; i < static_cast<int>(problems.size()) && i <= to; ++i) {
      const CoveredProblem& p = problems[static_cast<std::size_t>(i)];
      if (!only.empty() && p.name != only) continue;
      for (const std::string& where : p.truths) {
        const Tally t = cover(p, where, studies, runs);
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
