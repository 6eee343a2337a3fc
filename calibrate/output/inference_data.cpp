// The posterior as posterior.nc in the InferenceData layout (docs/calibration.md).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "calibrate/output/calibration_result.h"
#include "calibrate/output/text_format.h"
#include "experiments/analysis/random_stream.h"
#include "experiments/storage/netcdf_file.h"
#include "experiments/storage/version.h"
#include "experiments/system/output_file.h"

namespace firn {
namespace {

using Eigen::VectorXd;

constexpr std::size_t draws = 4096;

// A slash would lead into a group.
std::string variable_name(std::string label) {
  std::replace(label.begin(), label.end(), '/', '_');
  return label;
}

// A name that no variable of a target has, nor an added one before.
std::string added_name(std::string name, std::set<std::string>& taken) {
  while (!taken.insert(name).second) name += '_';
  return name;
}

void write_groups(NetcdfFile& file, const Study& study, const CalibrationResult& a) {
  const std::vector<VectorXd> u = resampled(*a.posterior, draws);
  const NegativeLogPosterior misfit(study, *a.models);
  NetcdfAttributes made = {{"inference_library", "firn"},
                           {"inference_library_version", firn_version()},
                           {"study", study.name}};
  if (study.chosen) made.emplace_back("choice", study.chosen_text());
  const std::vector<std::string> per_draw = {"chain", "draw"};
  for (const char* name : {"posterior", "sample_stats", "posterior_predictive"}) {
    file.group(name, made);
    file.dimension(name, "chain", 1);
    file.dimension(name, "draw", u.size());
  }
  std::vector<double> values(u.size());
  for (std::size_t i = 0; i < study.parameters.size(); ++i) {
    const Parameter& p = study.parameters[i];
    for (std::size_t s = 0; s < u.size(); ++s)
      values[s] = p.from_unit(u[s][static_cast<Eigen::Index>(i)]);
    file.variable("posterior", p.name, per_draw, values, {{"units", stored_unit(p.unit)}});
  }
  std::ranges::transform(u, values.begin(),
                         [&](const VectorXd& x) { return -0.5 * misfit.cost(x); });
  file.variable("sample_stats", "lp", per_draw, values);
  file.group("observed_data", made);
  std::set<std::string> taken;
  for (const Target& t : study.targets) taken.insert(variable_name(t.response.label));
  std::vector<double> means(u.size()), runs(u.size());
  std::mt19937_64 random(20061), random_runs(20062);
  for (std::size_t k = 0; k < study.targets.size(); ++k) {
    const Target& t = study.targets[k];
    const std::string name = variable_name(t.response.label), dimension = name + "_dim_0";
    for (const char* group : {"observed_data", "posterior_predictive"})
      file.dimension(group, dimension, 1);
    NetcdfAttributes measured = {{"units", stored_unit(t.unit)},
                                 {"standard_uncertainty", fmt::format("{}", t.uncertainty)}};
    if (t.discrepancy > 0)
      measured.emplace_back("discrepancy_standard_deviation", fmt::format("{}", t.discrepancy));
    file.variable("observed_data", name, {dimension}, std::span(&t.value, 1), measured);
    for (std::size_t s = 0; s < u.size(); ++s) {
      const ResponseModel& model = a.models->targets[k];
      const Prediction p = model.surrogate.best.predict(u[s]);
      values[s] = p.mean + std::hypot(t.sd(), std::sqrt(p.variance)) * normal_deviate(random);
      means[s] = p.mean;
      runs[s] = p.mean + std::sqrt(p.variance + model.run_variance(u[s], p.mean)) *
                             normal_deviate(random_runs);
    }
    const NetcdfAttributes units = {{"units", stored_unit(t.unit)}};
    file.variable("posterior_predictive", name, {"chain", "draw", dimension}, values, units);
    for (const auto& [suffix, drawn] : {std::pair("_mean", &means), std::pair("_run", &runs)})
      file.variable("posterior_predictive", added_name(name + suffix, taken), per_draw, *drawn,
                    units);
  }
}

}  // namespace

void write_inference_data(const Study& study, const CalibrationResult& result,
                          const std::string& file) {
  try {
    NetcdfFile netcdf(file);
    write_groups(netcdf, study, result);
    netcdf.commit();
  } catch (const hdf5::Error& e) {
    throw WriteError(file, e.what());
  }
}

}  // namespace firn
