#include "tests/calibration_proof/simulated.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <random>

#include "calibrate/calibration.h"
#include "calibrate/study/study_runs.h"
#include "experiments/analysis/random_stream.h"
#include "experiments/analysis/sample_statistics.h"
#include "experiments/storage/version.h"
#include "tests/support/fake_experiment.h"

namespace firn::proof {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// Seeds of a study lie this far apart from those of the next; those of its truth, and those that
// judge its answer and its measurement, are out of its reach.
constexpr std::uint64_t study_stride = 10000, truth_seeds = 6000, fresh_seeds = 7000,
                        further_seeds = 8000;

std::vector<double> values_of(const std::vector<JobResult>& runs, const std::string& name) {
  std::vector<double> values;
  for (const JobResult& run : runs)
    for (const Response& r : run.responses)
      if (run.status == JobStatus::finished && r.name == name) values.push_back(r.value.at(0));
  return values;
}

std::string with_unit(double value, const std::string& unit) {
  return unit == "1" ? fmt::format("\"{}\"", value) : fmt::format("\"{} {}\"", value, unit);
}

// Of the mean, as a study takes it of repeats.
double mean_variance_of(const Sample& s) {
  return widened_variance(s.sum_of_squares / (s.count - 1), s.count - 1) / s.count;
}

std::string toml(const std::vector<Override>& set) {
  std::vector<std::string> parts;
  for (const auto& [key, value] : set) parts.push_back(fmt::format("\"{}\" = {}", key, value));
  return fmt::format("{{ {} }}", fmt::join(parts, ", "));
}

}  // namespace

std::string SimulatedProblem::Unknown::text(double value) const {
  return unit.empty() ? fmt::format("{}", value) : fmt::format("\"{} {}\"", value, unit);
}

const std::vector<SimulatedProblem>& simulated_problems() {
  const SimulatedProblem::Unknown ice{
      "ice_ice",
      {"interactions.ice-ice.static_friction", "interactions.ice-ice.dynamic_friction"},
      0.05,
      0.5};
  const SimulatedProblem::Unknown wall{
      "ice_plastic",
      {"interactions.ice-plastic.static_friction", "interactions.ice-plastic.dynamic_friction"},
      0.05,
      0.4};
  const SimulatedProblem::Unknown full_ice{ice.name, ice.keys, 0.02, 0.2};
  const SimulatedProblem::Measured count{"remaining_count", "1", 0.5, 0};
  const SimulatedProblem::Measured height{"fill_height", "m", 0.0003, 0};
  const std::string small = "tests/calibration_proof/small_box.toml";
  static const std::vector<SimulatedProblem> problems = {
      {"count", small, {ice, wall}, {count}, 7, {}, "runs = 36\n", 6, 40, false},
      {"count, three seeds a point",
       small,
       {ice, wall},
       {count},
       7,
       {},
       "runs = 36\nreplicates_per_point = 3\n",
       6,
       0,
       false},
      {"count and height", small, {ice, wall}, {count, height}, 7, {}, "runs = 36\n", 6, 40, false},
      // Soft contacts end at the limit of overlap, high friction bridges the door.
      {"gaps",
       "tests/calibration_proof/narrow_door.toml",
       {{"young_modulus", {"materials.ice.young_modulus"}, 0.06, 0.5, "MPa"},
        {ice.name, ice.keys, 0.05, 0.3}},
       {count, {"peak_normal_force", "N", 0.1, 0}},
       7,
       {{"numerics.overlap_limit", "0.17"}},
       "runs = 40\n",
       6,
       0,
       false},
      {"full size",
       "cases/drained_repose/case.toml",
       {full_ice, wall},
       {{"angle_of_repose", "deg", 0.6,
         3}},  // 3 deg: of the full study, docs/drained-repose-answer.md
       3,
       {},
       "center_replicates = 5\ndesign_points = 9\nruns_per_point = 2\nrefine_rounds = 1\n"
       "refine_points = 2\nconfirm_runs = 3\n",
       0,
       0,
       true},
  };
  return problems;
}

SimulatedStudies::SimulatedStudies(const SimulatedProblem& problem, const std::string& folder,
                                   const std::string& store, const std::string& program, int jobs,
                                   bool plot)
    : problem_(problem),
      folder_(folder),
      store_file_(store),
      program_(program),
      store_(store),
      jobs_(jobs),
      plot_(plot) {
  LocalExecutorOptions options;
  options.program = program_;
  options.jobs = jobs;
  executor_ = local_executor(options);
  fs::create_directories(folder_);
}

// Runs outside of any study: without its limits.
std::vector<JobResult> SimulatedStudies::runs_at(const Values& values, std::uint64_t first_seed,
                                                 int count) {
  std::vector<Job> jobs;
  std::map<std::string, JobResult> results;
  std::vector<std::string> keys;
  const std::string case_file = (fs::path(FIRN_SOURCE_DIR) / problem_.case_file).string();
  for (const std::uint64_t seed : seed_list(first_seed, count)) {
    Job job;
    job.overrides = {{"case.seed", std::to_string(seed)}};
    for (std::size_t i = 0; i < values.size(); ++i)
      for (const std::string& key : problem_.unknowns[i].keys)
        job.overrides.emplace_back(key, problem_.unknowns[i].text(values[i]));
    job.case_file = case_file;
    job.text = executor_->resolve(job.case_file, job.overrides, {}).text;
    job.key = run_key(job.text, program_identity());
    job.folder = (fs::path(folder_) / "runs").string();
    keys.push_back(job.key);
    if (const auto known = store_.find(job.key))
      results[job.key] = *known;
    else
      jobs.push_back(job);
  }
  JobEvents events;
  events.started = [](const Job&) {};
  events.ended = [&](const Job& job, const JobResult& result) {
    results[job.key] = result;
    store_.add({job.key, job.text, program_identity(), {}}, result);
  };
  executor_->run(jobs, events);
  fs::remove_all(fs::path(folder_) / "runs");
  std::vector<JobResult> in_order;
  for (const std::string& key : keys) in_order.push_back(results.at(key));
  return in_order;
}

// The repeats of each measured response, with the error of its reading.
std::vector<SimulatedStudies::Values> SimulatedStudies::repeats_of(
    const std::vector<JobResult>& runs, int number) const {
  std::mt19937_64 random(static_cast<std::uint64_t>(7919 * number + 13));
  std::vector<Values> repeats;
  for (const SimulatedProblem::Measured& m : problem_.measured) {
    const double offset = m.reading * normal_deviate(random);
    Values values = values_of(runs, m.response);
    for (double& v : values) v += offset;
    repeats.push_back(values);
  }
  return repeats;
}

// As a laboratory would hand them in: the repeats, or their mean and what is assumed of the
// scatter.
void SimulatedStudies::write_measurements(const std::vector<Values>& repeats) const {
  for (std::size_t i = 0; i < repeats.size(); ++i) {
    const SimulatedProblem::Measured& m = problem_.measured[i];
    const Values& values = repeats[i];
    std::string text = fmt::format(
        "name = \"simulated\"\nresponse = \"{}\"\nstatus = \"measured\"\nsource = \"a run\"\n",
        m.response);
    if (m.assumed_sd > 0) {
      text += fmt::format("value = {}\nrepeats = {}\n[scatter]\nkind = \"not stated\"\n",
                          with_unit(sample(values).mean, m.unit), values.size());
      text += fmt::format("assumed_standard_deviation = {}\nassumed_because = \"of other seeds\"\n",
                          with_unit(m.assumed_sd, m.unit));
    } else {
      std::vector<std::string> texts;
      for (const double v : values) texts.push_back(with_unit(v, m.unit));
      text += fmt::format("values = [{}]\n", fmt::join(texts, ", "));
    }
    text += fmt::format("[systematic]\nuncertainty = {}\nrationale = \"drawn\"\n",
                        with_unit(m.reading, m.unit));
    std::ofstream(fs::path(folder_) / (m.response + ".toml")) << text;
  }
}

std::string SimulatedStudies::study_text(const Values& truth, std::uint64_t seed) const {
  // A study that begins with the runs of another one is not independent of it.
  std::string text = fmt::format(
      "[study]\nname = \"hidden\"\nseed = {}\n[budget]\n{}compare_replicates = 0\n"
      "reuse = false\n"
      "[[experiments]]\nname = \"box\"\ncase = \"{}\"\n",
      seed, problem_.budget,
      fs::relative(fs::path(FIRN_SOURCE_DIR) / problem_.case_file, folder_).string());
  if (!problem_.limits.empty()) text += fmt::format("set = {}\n", toml(problem_.limits));
  std::vector<std::string> names;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const SimulatedProblem::Unknown& p = problem_.unknowns[i];
    text += fmt::format(
        "[[parameters]]\nname = \"{}\"\nkeys = [\"{}\"]\nmin = {}\nmax = {}\nscale = \"log\"\n",
        p.name, fmt::join(p.keys, "\", \""), p.text(p.min), p.text(p.max));
    names.push_back(fmt::format("{} = {}", p.name, p.text(truth[i])));
  }
  for (const SimulatedProblem::Measured& m : problem_.measured)
    text += fmt::format("[[targets]]\nmeasurement = \"{}.toml\"\n", m.response);
  return text +
         fmt::format("[[compare]]\nname = \"truth\"\nvalues = {{ {} }}\n", fmt::join(names, ", "));
}

namespace {

// What the results of a study say of the truth, which is its first [[compare]] set.
void judge_truth(const json& results, Verdict& v) {
  v.hpd_level = results["compare"][0]["hpd_level"];
  for (std::size_t i = 0; i < v.truth.size(); ++i) {
    const json& interval = results["parameters"][i]["interval_95"];
    v.intervals += interval[0] <= v.truth[i] && v.truth[i] <= interval[1];
  }
  if (results["combinations"].empty() || !results["combinations"][0]["identifiable"]) return;
  const json& c = results["combinations"][0];
  double at_truth = 0;
  for (std::size_t i = 0; i < v.truth.size(); ++i)
    at_truth += c["terms"][i]["coefficient"].get<double>() * std::log(v.truth[i]);
  const double off = at_truth - c["value"].get<double>();
  v.combination_z = off / c["uncertainty"].get<double>();
  v.strayed_z = off / c["spread_over_posterior"].get<double>();
}

}  // namespace

SimulatedStudies::Values SimulatedStudies::drawn_truth(int number) const {
  std::mt19937_64 random(static_cast<std::uint64_t>(104729 * number + 1));
  Values truth;
  for (const SimulatedProblem::Unknown& p : problem_.unknowns)
    truth.push_back(p.min * std::pow(p.max / p.min, uniform_open(random)));
  return truth;
}

// The repeats of the measurements; nothing where one did not finish.
std::optional<std::vector<JobResult>> SimulatedStudies::measured_at(const Values& truth,
                                                                    std::uint64_t first_seed) {
  std::vector<JobResult> measured;
  for (int i = 0; i < problem_.repeats; ++i) {
    measured.push_back(runs_at(truth, first_seed + static_cast<std::uint64_t>(i), 1).front());
    if (measured.back().status != JobStatus::finished) return std::nullopt;
  }
  return measured;
}

// Carries out the study in the file; its results as JSON.
std::string SimulatedStudies::results_of(const std::string& file, int number) const {
  StudyOptions options;
  options.study_file = file;
  options.directory = (fs::path(folder_) / fmt::format("study-{}", number)).string();
  fs::remove_all(options.directory);  // the store knows what was run
  options.jobs = jobs_;
  options.program = program_;
  options.store = store_file_;
  options.show_progress = false;
  options.plot = plot_;
  const std::string results = calibrate(options).json;
  fs::remove_all(fs::path(options.directory) / "runs");
  return results;
}

// Separates an error of the measurement from one of the fitted response.
void SimulatedStudies::judge_at_truth(const std::vector<Values>& repeats,
                                      const std::string& results, std::uint64_t first_seed,
                                      Verdict& v) {
  const auto runs = runs_at(v.truth, first_seed, problem_.at_truth);
  const json fit = json::parse(results)["compare"][0]["fit"];
  for (std::size_t i = 0; i < repeats.size(); ++i) {
    const SimulatedProblem::Measured& m = problem_.measured[i];
    const Sample measured = sample(repeats[i]), more = sample(values_of(runs, m.response));
    if (more.count < 2) continue;
    const double variance = m.assumed_sd > 0 ? m.assumed_sd * m.assumed_sd / measured.count
                                             : mean_variance_of(measured);
    v.measured_z.push_back((measured.mean - more.mean) /
                           std::sqrt(variance + m.reading * m.reading + mean_variance_of(more)));
    v.fitted_z.push_back((fit[m.response]["value"].get<double>() - more.mean) /
                         std::hypot(fit[m.response]["uncertainty"].get<double>(),
                                    std::sqrt(mean_variance_of(more))));
  }
}

// Distances of a stated response at the estimate from that of fresh runs there, in standard errors.
std::vector<double> SimulatedStudies::reported_z(const std::string& results,
                                                 std::uint64_t first_seed) {
  const json estimate = json::parse(results).at("estimate");
  Values answer;
  for (const SimulatedProblem::Unknown& p : problem_.unknowns)
    answer.push_back(estimate["parameters"][p.name]);
  const auto runs = runs_at(answer, first_seed, problem_.fresh);
  std::vector<double> all;
  for (const SimulatedProblem::Measured& m : problem_.measured) {
    const json& stated = estimate["simulated"][m.response];
    const Sample fresh = sample(values_of(runs, m.response));
    if (fresh.count < 2 || stated["value"].is_null()) continue;
    all.push_back(
        (stated["value"].get<double>() - fresh.mean) /
        std::hypot(stated["standard_error"].get<double>(), std::sqrt(mean_variance_of(fresh))));
  }
  return all;
}

std::optional<Verdict> SimulatedStudies::study(int number) {
  Verdict v;
  v.truth = drawn_truth(number);
  const std::uint64_t own = study_stride * static_cast<std::uint64_t>(number + 1);
  const auto measured = measured_at(v.truth, own + truth_seeds);
  if (!measured) return std::nullopt;
  const std::vector<Values> repeats = repeats_of(*measured, number);
  write_measurements(repeats);
  const std::string file = (fs::path(folder_) / "study.toml").string();
  std::ofstream(file) << study_text(v.truth, problem_.same_design ? 1 : own);
  const std::string results = results_of(file, number);
  const json j = json::parse(results);
  v.verdict = j["verdict"];
  v.runs = j["runs"]["total"];
  v.arched = j["runs"]["arched"];
  v.failed = j["runs"]["failed"];
  v.wall = j["wall_seconds"];
  if (!j["compare"][0].contains("hpd_level")) return v;
  judge_truth(j, v);
  if (problem_.at_truth > 0) judge_at_truth(repeats, results, own + further_seeds, v);
  if (problem_.fresh > 0 && j.contains("estimate") && j["estimate"].contains("simulated"))
    v.reported_z = reported_z(results, own + fresh_seeds);
  return v;
}

}  // namespace firn::proof
