// Does the calibration keep its word? Studies of problems whose truth is known, many times over:
// how often the stated region holds the truth, whether the reported error is the true one, and
// whether the engine is worth its complexity. Prints Markdown; ends with status 1 when a claim
// fails.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <nlohmann/json.hpp>

#include "calibrate/numerics/experimental_design.h"
#include "experiments/analysis/random_stream.h"
#include "tests/calibration_proof/problems.h"

namespace firn::proof {
namespace {

using nlohmann::json;

bool all_kept = true;

void claim(bool kept, const std::string& what) {
  all_kept = all_kept && kept;
  fmt::print("{} {}\n", kept ? "Kept:" : "**NOT KEPT:**", what);
}

// A measurement of the truth: its own error, the same for every method that is compared.
std::vector<double> measured(const Problem& problem, int study) {
  std::mt19937_64 random(static_cast<std::uint64_t>(7919 * study + 13));
  std::vector<double> target;
  for (const ProofResponse& r : problem.responses)
    target.push_back(r.value(problem.truth) + r.uncertainty * normal_deviate(random));
  return target;
}

json solve(const Problem& problem, const std::vector<double>& target, int runs, int study,
           const std::string& more = "") {
  const Folder folder("proof");
  FakeExperiment experiment = problem.experiment();
  const std::string file =
      folder.write("study.toml", study_text(problem, target, runs, 1 + 10000 * study, more));
  return json::parse(run_study(file, folder / "out", experiment).json);
}

std::vector<double> answer_of(const Problem& problem, const json& j) {
  std::map<std::string, double> by_key;
  for (const auto& [name, value] : j["estimate"]["parameters"].items()) by_key[name] = value;
  return problem.values(by_key);
}

double median(std::vector<double> x) {
  std::sort(x.begin(), x.end());
  return x.empty() ? std::nan("") : x[x.size() / 2];
}

// Two-sided: so far from the nominal share that chance explains it once in a thousand times.
bool plausible(int inside, int count, double share) {
  const double sd = std::sqrt(share * (1 - share) * count);
  return std::abs(inside - share * count) <= 3.3 * sd + 0.5;
}

// How often the 95 % region, and each parameter's 95 % interval, hold the truth; and whether the
// answer's reported response is the true one within its stated standard error.
void coverage(const std::vector<Problem>& problems, int studies, int runs) {
  fmt::print("## Does the 95 % region hold the truth 95 % of the time?\n\n");
  fmt::print(
      "{} studies of {} runs for each problem, each with a separate measurement and "
      "separate seeds.\n\n",
      studies, runs);
  fmt::print(
      "| problem | region | intervals of single parameters | mean share denser than the truth "
      "(0.5) | reported error over true error (1) |\n|---|---|---|---|---|\n");
  int all_inside = 0, all_count = 0;
  for (const Problem& problem : problems) {
    int inside = 0, interval = 0, intervals = 0, count = 0, reported = 0;
    double hpd_level = 0, z2 = 0;
    for (int s = 0; s < studies; ++s) {
      const std::vector<double> target = measured(problem, s);
      const json j = solve(problem, target, runs, s);
      // A measurement by chance beyond what the ranges can give has no region to be in.
      if (!j.contains("estimate") || j["verdict"] == "infeasible") continue;
      ++count;
      const json& truth = j["compare"][0];
      inside += truth["inside_95_region"].get<bool>();
      hpd_level += truth["hpd_level"].get<double>();
      for (std::size_t i = 0; i < problem.parameters.size(); ++i, ++intervals) {
        const json& v = j["parameters"][i]["interval_95"];
        interval += v[0] <= problem.truth[i] && problem.truth[i] <= v[1];
      }
      const std::vector<double> answer = answer_of(problem, j);
      for (const ProofResponse& r : problem.responses) {
        const json& o = j["estimate"]["simulated"][r.name];
        if (o["value"].is_null()) continue;  // all of them failed
        const double error = o["value"].get<double>() - r.value(answer);
        z2 += std::pow(error / o["standard_error"].get<double>(), 2);
        ++reported;
      }
    }
    fmt::print("| {} | {} of {} ({:.1f} %) | {:.1f} % | {:.2f} | {:.2f} |\n", problem.name, inside,
               count, 100.0 * inside / count, 100.0 * interval / intervals, hpd_level / count,
               std::sqrt(z2 / reported));
    all_inside += inside;
    all_count += count;
  }
  fmt::print("| all | {} of {} ({:.1f} %) | | | |\n\n", all_inside, all_count,
             100.0 * all_inside / all_count);
  claim(plausible(all_inside, all_count, 0.95) || all_inside > 0.95 * all_count,
        "over all problems the 95 % region holds the truth at least as often as 95 % allows by "
        "chance.");
}

// Points drawn at random, one run each; the one whose run came nearest to the target.
double random_search(const Problem& problem, const std::vector<double>& target, int runs,
                     int study) {
  std::mt19937_64 random(static_cast<std::uint64_t>(104729 * study + 1));
  double best = 0, true_distance = 0;
  for (int i = 0; i < runs; ++i) {
    std::vector<double> p;
    for (const Problem::Range& r : problem.parameters)
      p.push_back(r.logarithmic ? r.min * std::pow(r.max / r.min, uniform_open(random))
                                : r.min + (r.max - r.min) * uniform_open(random));
    double seen = 0;
    for (std::size_t k = 0; k < target.size(); ++k) {
      const ProofResponse& r = problem.responses[k];
      seen +=
          std::pow((r.value(p) + r.noise * normal_deviate(random) - target[k]) / r.uncertainty, 2);
    }
    if (i == 0 || seen < best) {
      best = seen;
      true_distance = problem.distance(p, target);
    }
  }
  return true_distance;
}

void searches(const std::vector<Problem>& problems, int studies, int runs) {
  fmt::print("\n## Is the engine worth its runs?\n\n");
  fmt::print(
      "{} runs for each method, {} studies each; median over the studies of the true distance "
      "of the answer from the targets, in standard deviations of the measurement. In "
      "brackets what a direct search believed of its best.\n\n",
      runs, studies);
  fmt::print(
      "| problem | engine | random search | BOBYQA | COBYLA | Nelder-Mead | CRS |\n"
      "|---|---|---|---|---|---|---|\n");
  std::vector<std::string> lost;
  for (const Problem& problem : problems) {
    if (problem.ends) continue;
    std::vector<double> engine, chance;
    std::map<std::string, std::vector<double>> direct, believed;
    for (int s = 0; s < studies; ++s) {
      std::vector<double> target;
      for (const ProofResponse& r : problem.responses) target.push_back(r.value(problem.truth));
      const json j = solve(problem, target, runs, s);
      engine.push_back(problem.distance(answer_of(problem, j), target));
      chance.push_back(random_search(problem, target, runs, s));
      for (const char* search : {"bobyqa", "cobyla", "nelder-mead", "crs"}) {
        const json d = solve(
            problem, target, runs, s,
            fmt::format("[direct]\nsearch = \"{}\"\nevaluations = {}\n", search, (runs - 3) / 2));
        direct[search].push_back(problem.distance(answer_of(problem, d), target));
        believed[search].push_back(d["direct_search"]["best_observed_distance"]);
      }
    }
    fmt::print("| {} | {:.2f} | {:.2f}", problem.name, median(engine), median(chance));
    for (const char* search : {"bobyqa", "cobyla", "nelder-mead", "crs"})
      fmt::print(" | {:.2f} ({:.2f})", median(direct[search]), median(believed[search]));
    fmt::print(" |\n");
    if (!(median(engine) < median(chance))) lost.push_back(problem.name);
  }
  fmt::print("\n");
  claim(lost.empty(),
        lost.empty() ? "the engine beats random search on every problem."
                     : fmt::format("random search beats the engine on {}.", fmt::join(lost, ", ")));
}

}  // namespace
}  // namespace firn::proof

int main(int argc, char** argv) {
  CLI::App app("Does the calibration keep its word?");
  int studies = 100, searched = 20, runs = 40;
  app.add_option("--studies", studies, "studies for each problem")->capture_default_str();
  app.add_option("--searches", searched, "searches for each problem")->capture_default_str();
  app.add_option("--runs", runs, "runs of each study")->capture_default_str();
  std::string only;
  app.add_option("--problem", only, "of this name alone");
  CLI11_PARSE(app, argc, argv);
  auto problems = firn::proof::reference_problems();
  if (!only.empty())
    std::erase_if(problems, [&](const firn::proof::Problem& p) { return p.name != only; });
  firn::proof::coverage(problems, studies, runs);
  firn::proof::searches(problems, searched, runs);
  return firn::proof::all_kept ? 0 : 1;
}
