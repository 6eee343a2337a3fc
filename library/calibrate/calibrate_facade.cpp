#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "calibrate/calibrate.h"
#include "calibrate/output/calibration_result.h"
#include "calibrate/study/study_file.h"
#include "experiments/system/temporary_folder.h"
#include "experiments/text/number_text.h"
#include "firn/calibrate/calibrate.h"
#include "firn/math.h"
#include "library/calibrate/function_executor.h"

namespace firn::calibration {
namespace {

// As a TOML basic string: JSON strings are among them.
std::string quoted(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string quantity(double value, const std::string& unit) {
  return unit.empty() ? fmt::format("{}", value) : quoted(fmt::format("{} {}", value, unit));
}

void check(const Problem& problem) {
  for (const Parameter& p : problem.parameters) {
    if (p.name.empty() ||
        p.name.find_first_not_of("abcdefghijklmnopqrstuvwxyz"
                                 "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-") != std::string::npos)
      throw InputError(
          fmt::format("parameters: name: is \"{}\"; expected letters, digits, _ and -", p.name));
    if (!std::isfinite(p.min) || !std::isfinite(p.max) || !(p.min < p.max))
      throw InputError(fmt::format(
          "parameters: {}: the range is {} to {}; expected finite numbers with min below max",
          p.name, p.min, p.max));
    if (p.logarithmic && !(p.min > 0))
      throw InputError(
          fmt::format("parameters: {}: the range begins at {}; expected above 0 for a logarithm",
                      p.name, p.min));
  }
  for (const Target& t : problem.targets) {
    if (!std::isfinite(t.discrepancy) || t.discrepancy < 0)
      throw InputError(
          fmt::format("targets: {}: the discrepancy is {}; expected a finite number of at least 0",
                      t.response, t.discrepancy));
    if (!std::isfinite(t.value) || !std::isfinite(t.uncertainty) || !(t.uncertainty > 0))
      throw InputError(fmt::format(
          "targets: {}: is {} +- {}; expected a finite value and an uncertainty above 0",
          t.response, t.value, t.uncertainty));
  }
}

// The study file of `firn calibrate` that says the same.
std::string study_text(const Problem& problem) {
  std::string text = fmt::format("[study]\nname = {}\nseed = {}\n\n[budget]\nruns = {}\n",
                                 quoted(problem.name), problem.seed, problem.runs);
  for (const Parameter& p : problem.parameters) {
    text += fmt::format("\n[[parameters]]\nname = {}\nkeys = [{}]\nmin = {}\nmax = {}\n",
                        quoted(p.name), quoted(p.name), quantity(p.min, p.unit),
                        quantity(p.max, p.unit));
    if (p.logarithmic) text += "scale = \"log\"\n";
    if (p.prior_mean) text += fmt::format("prior_mean = {}\n", quantity(*p.prior_mean, p.unit));
    if (p.prior_sd) text += fmt::format("prior_sd = {}\n", quantity(*p.prior_sd, p.unit));
  }
  for (const Target& t : problem.targets) {
    const std::string unit = unit_text(t.unit);
    text += fmt::format("\n[[targets]]\nresponse = {}\nvalue = {}\nuncertainty = {}\n",
                        quoted(t.response), quantity(t.value, unit), quantity(t.uncertainty, unit));
    if (t.discrepancy > 0) text += fmt::format("discrepancy = {}\n", quantity(t.discrepancy, unit));
  }
  return text;
}

void add_estimates(const Study& study, const CalibrationResult& answer, Result& result) {
  if (!answer.posterior || answer.best.values.size() != study.parameters.size()) return;
  const Posterior& posterior = *answer.posterior;
  for (std::size_t i = 0; i < study.parameters.size(); ++i) {
    const Marginal& m = posterior.marginals[i];
    result.estimates.push_back({study.parameters[i].name, study.parameters[i].unit,
                                answer.best.values[i], m.median, m.low, m.high, m.at_min,
                                m.at_max});
  }
  result.weights = posterior.weight;
  result.samples.reserve(posterior.u.size() * study.parameters.size());
  for (const Eigen::VectorXd& u : posterior.u)
    for (std::size_t i = 0; i < study.parameters.size(); ++i)
      result.samples.push_back(study.parameters[i].from_unit(u[static_cast<Eigen::Index>(i)]));
}

}  // namespace

Result calibrate(const Problem& problem, const Simulator& simulator, const Options& options) {
  check(problem);
  if (!simulator) throw InputError("simulator: is missing; expected a function");
  if (options.jobs < 1 || options.jobs > 1024)
    throw InputError(fmt::format("jobs: is {}; expected a number from 1 to 1024", options.jobs));
  FunctionExecutor executor(simulator, options);
  std::optional<TemporaryFolder> temporary;
  if (options.directory.empty()) temporary.emplace("calibration");
  StudyOptions o;
  o.directory = temporary ? temporary->file("study") : options.directory;
  o.jobs = options.jobs;
  o.show_progress = false;
  o.plot = false;
  o.interrupt = &executor.stopped();
  o.replace_executor = &executor;
  Result result;
  o.on_result = [&](const Study& study, const CalibrationResult& answer) {
    result.runs = answer.runs;
    add_estimates(study, answer, result);
  };
  StudySummary summary = firn::calibrate(
      read_function_study(study_text(problem), "study \"" + problem.name + "\""), o);
  result.verdict = to_string(summary.verdict);
  result.headline = std::move(summary.headline);
  result.table = std::move(summary.table);
  result.json = std::move(summary.json);
  return result;
}

}  // namespace firn::calibration
