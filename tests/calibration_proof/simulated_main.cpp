// Does the calibration keep its word where the truth is a simulation's? Prints Markdown, and a line
// for each study into studies.csv. Runs are kept in a store: a second call resumes from there.
#include <fmt/format.h>
#include <fmt/os.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>

#include "tests/calibration_proof/simulated.h"

namespace firn::proof {
namespace {

// Wilson's 95 % interval of a share.
std::array<double, 2> share_interval(int inside, int count) {
  constexpr double z = 1.96;
  const double n = count, p = inside / n, middle = (p + z * z / (2 * n)) / (1 + z * z / n);
  const double half = z * std::sqrt(p * (1 - p) / n + z * z / (4 * n * n)) / (1 + z * z / n);
  return {middle - half, middle + half};
}

// Chance that values drawn uniformly between 0 and 1 are as far from uniform as these: Kolmogorov.
double chance_if_uniform(std::vector<double> x) {
  std::sort(x.begin(), x.end());
  const double n = static_cast<double>(x.size());
  double distance = 0;
  for (std::size_t i = 0; i < x.size(); ++i)
    distance = std::max({distance, x[i] - double(i) / n, double(i + 1) / n - x[i]});
  const double t = distance * (std::sqrt(n) + 0.12 + 0.11 / std::sqrt(n));
  double sum = 0;
  for (int k = 1; k <= 100; ++k) sum += (k % 2 == 1 ? 2 : -2) * std::exp(-2.0 * k * k * t * t);
  return std::clamp(sum, 0.0, 1.0);
}

// Chance of at most so many inside when each is inside with this share.
double chance_of_so_few(int inside, int count, double share) {
  double sum = 0;
  for (int k = 0; k <= inside; ++k)
    sum += std::exp(std::lgamma(count + 1) - std::lgamma(k + 1) - std::lgamma(count - k + 1) +
                    k * std::log(share) + (count - k) * std::log(1 - share));
  return sum;
}

double root_mean_square(const std::vector<double>& x) {
  double sum = 0;
  for (const double v : x) sum += v * v;
  return std::sqrt(sum / static_cast<double>(x.size()));
}

// Whether chance explains more than once in a thousand times that no more truths are inside.
bool report(const SimulatedProblem& problem, const std::vector<Verdict>& all, int asked) {
  std::vector<double> hpd_level, combination, strayed, reported, measured, fitted;
  std::map<std::string, int> verdicts;
  int inside = 0, intervals = 0, arched = 0, failed = 0, runs = 0;
  for (const Verdict& v : all) {
    ++verdicts[v.verdict];
    runs += v.runs;
    arched += v.arched;
    failed += v.failed;
    measured.insert(measured.end(), v.measured_z.begin(), v.measured_z.end());
    fitted.insert(fitted.end(), v.fitted_z.begin(), v.fitted_z.end());
    if (!v.hpd_level) continue;
    hpd_level.push_back(*v.hpd_level);
    inside += *v.hpd_level <= 0.95;
    intervals += v.intervals;
    if (v.combination_z) combination.push_back(*v.combination_z);
    if (v.strayed_z) strayed.push_back(*v.strayed_z);
    reported.insert(reported.end(), v.reported_z.begin(), v.reported_z.end());
  }
  const int count = static_cast<int>(hpd_level.size());
  fmt::print("### {}\n\n{} truths drawn, {} measured, {} runs in the studies", problem.name, asked,
             all.size(), runs);
  fmt::print(" ({} arched, {} failed). Verdicts:", arched, failed);
  for (const auto& [verdict, times] : verdicts) fmt::print(" {} {};", times, verdict);
  fmt::print("\n\n");
  if (count == 0) return false;
  const auto [low, high] = share_interval(inside, count);
  fmt::print("| | |\n|---|---|\n");
  fmt::print(
      "| truth in the 95 % region | {} of {} ({:.1f} %; 95 % interval {:.1f} to {:.1f} %) |\n",
      inside, count, 100.0 * inside / count, 100 * low, 100 * high);
  fmt::print("| truth in the 95 % interval of a parameter | {} of {} |\n", intervals,
             count * static_cast<int>(problem.unknowns.size()));
  double mean = 0;
  std::array<int, 5> fifths{};
  for (const double d : hpd_level) {
    mean += d / count;
    ++fifths[std::min<std::size_t>(4, static_cast<std::size_t>(5 * d))];
  }
  fmt::print("| share denser than the truth: mean (0.5), fifths | {:.2f}, {} |\n", mean,
             fmt::join(fifths, " "));
  fmt::print("| chance of such shares if uniform | {:.2f} |\n", chance_if_uniform(hpd_level));
  if (!combination.empty())
    fmt::print(
        "| determined combination at the truth: error over stated, over its spread (1) | {:.2f}, "
        "{:.2f} ({}) |\n",
        root_mean_square(combination), root_mean_square(strayed), combination.size());
  if (!reported.empty())
    fmt::print("| error of the confirmed response over stated (1) | {:.2f} ({}) |\n",
               root_mean_square(reported), reported.size());
  const auto against_further_runs = [](const char* what, const std::vector<double>& z) {
    if (z.empty()) return;
    const auto within = std::ranges::count_if(z, [](double one) { return std::abs(one) < 1.96; });
    fmt::print("| {} at the truth: error over stated (1), within 1.96 | {:.2f}, {} of {} |\n", what,
               root_mean_square(z), within, z.size());
  };
  against_further_runs("measured response", measured);
  against_further_runs("fitted response", fitted);
  const bool kept = chance_of_so_few(inside, count, 0.95) > 0.001;
  fmt::print("\n{} the 95 % region holds the truth as often as 95 % allows by chance.\n\n",
             kept ? "Kept:" : "**NOT KEPT:**");
  return kept;
}

int run(const SimulatedProblem& problem, int first, int studies, const std::string& folder,
        const std::string& store, const std::string& program, int jobs, bool plot) {
  SimulatedStudies all(problem, folder, store, program, jobs, plot);
  std::vector<Verdict> verdicts;
  fmt::ostream csv = fmt::output_file((std::filesystem::path(folder) / "studies.csv").string());
  csv.print(
      "study,verdict,truth,denser,intervals,combination_z,reported_z,measured_z,fitted_z,runs,"
      "arched,failed,wall_s\n");
  for (int s = first; s < first + studies; ++s) {
    const auto v = all.study(s);
    if (!v) {
      csv.print("{},not measured\n", s);
      continue;
    }
    verdicts.push_back(*v);
    csv.print("{},{},{:.4g},{:.4f},{},{:.2f},{:.2f},{:.2f},{:.2f},{},{},{},{:.1f}\n", s, v->verdict,
              fmt::join(v->truth, " "), v->hpd_level.value_or(NAN), v->intervals,
              v->combination_z.value_or(NAN), fmt::join(v->reported_z, " "),
              fmt::join(v->measured_z, " "), fmt::join(v->fitted_z, " "), v->runs, v->arched,
              v->failed, v->wall);
    csv.flush();
  }
  return report(problem, verdicts, studies) ? 0 : 1;
}

}  // namespace
}  // namespace firn::proof

int main(int argc, char** argv) {
  CLI::App app("Does the calibration find a truth that was simulated?");
  std::string name, folder = "proof", store = "proof/store.db", program = FIRN_PROGRAM;
  int studies = 60, first = 0, jobs = 1, runs = 0;
  app.add_option("problem", name, "of this name")->required();
  app.add_option("--studies", studies, "how many")->capture_default_str();
  app.add_option("--first", first, "number of the first")->capture_default_str();
  app.add_option("--runs", runs, "of a study; that of the problem, unless given");
  app.add_option("--folder", folder, "for the studies")->capture_default_str();
  app.add_option("--store", store, "outcomes of runs")->capture_default_str();
  app.add_option("--program", program, "that simulates")->capture_default_str();
  app.add_option("--jobs", jobs, "runs side by side")->capture_default_str();
  bool plot = false;
  app.add_flag("--plot", plot, "draw each study's answer");
  CLI11_PARSE(app, argc, argv);
  try {
    for (firn::proof::SimulatedProblem problem : firn::proof::simulated_problems()) {
      if (problem.name != name) continue;
      if (runs > 0) problem.budget = fmt::format("runs = {}\n", runs);
      return firn::proof::run(problem, first, studies, folder, store, program, jobs, plot);
    }
    fmt::print(stderr, "no problem \"{}\"\n", name);
    return 2;
  } catch (const std::exception& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  }
}
