#include "calibrate/output/result_to_record.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "calibrate/output/text_format.h"
#include "experiments/measurements/measurement.h"
#include "experiments/storage/sha256.h"
#include "experiments/storage/version.h"
#include "experiments/system/input_file.h"
#include "experiments/system/input_limits.h"
#include "experiments/text/number_text.h"
#include "firn/contact_model.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
using Eigen::Index;

constexpr int kept_samples = 256;

// Six digits exceed the resolution of a posterior of some thousand points.
double rounded(const Parameter& p, double value) {
  return std::clamp(std::strtod(fmt::format("{:.6g}", value).c_str(), nullptr), p.min, p.max);
}

const Experiment* experiment_of(const Study& study, const JournalRun& run) {
  const auto it = std::ranges::find(study.experiments, run.label.experiment, &Experiment::name);
  return it == study.experiments.end() ? nullptr : &*it;
}

// Those of a run that the study fits or watches.
std::vector<MaterialResponse> responses_of(const Study& study, const JournalRun& run) {
  std::set<std::string> wanted;
  const auto want = [&](const ResponseId& id) {
    if (study.experiments[id.experiment].name == run.label.experiment) wanted.insert(id.name);
  };
  for (const Target& t : study.targets) want(t.response);
  for (const Observed& o : study.observed) want(o.response);
  std::vector<MaterialResponse> responses;
  for (const Response& r : run.result.responses)
    if (wanted.contains(r.name) && r.value.size() == 1 && std::isfinite(r.value[0]))
      responses.push_back({r.name, r.value[0], std::nullopt, stored_unit(r.unit)});
  return responses;
}

ReferenceSet reference_set_of(const Study& study, const CheckedSet& set, const std::string& name,
                              const std::vector<JournalRun>& runs, Executor& executor) {
  ReferenceSet reference{name, set.values, {}, {}};
  for (std::size_t k = 0; k < set.predicted.size(); ++k)
    reference.predicted.push_back({study.targets[k].response.label, set.predicted[k].mean,
                                   std::sqrt(set.predicted[k].variance),
                                   stored_unit(study.targets[k].unit)});
  if (!set.run()) return reference;
  std::map<std::pair<const Experiment*, std::uint64_t>, std::string> identities;  // by seed
  for (const JournalRun& run : runs) {
    const Experiment* experiment = experiment_of(study, run);
    if (experiment == nullptr || run.status != to_string(JobStatus::finished)) continue;
    // The same parameters and seed are the same complete case: the same key.
    std::string& identity = identities[{experiment, run.label.seed}];
    if (identity.empty())
      identity = executor
                     .resolve(experiment->case_file,
                              overrides_of(study, *experiment, set.values, run.label.seed), {})
                     .identity;
    if (run_key(identity, run.program) != run.key) continue;
    reference.runs.push_back({run.label.experiment, run.label.seed, responses_of(study, run)});
  }
  std::ranges::sort(reference.runs, {},
                    [](const ReferenceRun& run) { return std::pair(run.experiment, run.seed); });
  return reference;
}

// Every k-th part of the weight, along the direction in which the posterior stretches farthest.
std::vector<EnsembleSample> thinned(const Study& study, const Posterior& posterior) {
  std::vector<std::size_t> order(posterior.u.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {},
                           [&](std::size_t s) { return posterior.longest.dot(posterior.u[s]); });
  std::vector<EnsembleSample> samples;
  double sum = 0;
  int taken = 0;
  for (const std::size_t s : order) {
    sum += posterior.weight[s];
    int times = 0;
    for (; taken < kept_samples && sum > (taken + 0.5) / kept_samples; ++taken) ++times;
    if (times == 0) continue;
    EnsembleSample sample;
    for (std::size_t i = 0; i < study.parameters.size(); ++i) {
      const Parameter& p = study.parameters[i];
      sample.values.push_back(rounded(p, p.from_unit(posterior.u[s][static_cast<Index>(i)])));
    }
    sample.weight = static_cast<double>(times) / kept_samples;
    samples.push_back(sample);
  }
  return samples;
}

// Means and covariance of the scaled coordinates.
void fill_moments(const Study& study, const Posterior& posterior, PosteriorEnsemble& ensemble) {
  const std::size_t d = study.parameters.size();
  const auto coordinate = [&](std::size_t s, std::size_t i) {
    const Parameter& p = study.parameters[i];
    return p.scaled(p.min) + posterior.u[s][static_cast<Index>(i)] * p.width();
  };
  std::vector<double> mean(d, 0);
  ensemble.covariance.assign(d, std::vector<double>(d, 0));
  for (std::size_t s = 0; s < posterior.u.size(); ++s)
    for (std::size_t i = 0; i < d; ++i) mean[i] += posterior.weight[s] * coordinate(s, i);
  for (std::size_t s = 0; s < posterior.u.size(); ++s)
    for (std::size_t i = 0; i < d; ++i)
      for (std::size_t j = 0; j <= i; ++j)
        ensemble.covariance[i][j] +=
            posterior.weight[s] * (coordinate(s, i) - mean[i]) * (coordinate(s, j) - mean[j]);
  for (std::size_t i = 0; i < d; ++i) {
    for (std::size_t j = 0; j < i; ++j) ensemble.covariance[j][i] = ensemble.covariance[i][j];
    const Parameter& p = study.parameters[i];
    ensemble.axes.push_back(
        {p.name, p.logarithmic ? Scale::logarithmic : Scale::linear, {p.min, p.max}, mean[i]});
  }
}

double standard_deviation(const Parameter& p, const Posterior& posterior, std::size_t i) {
  double mean = 0, square = 0;
  for (std::size_t s = 0; s < posterior.u.size(); ++s)
    mean += posterior.weight[s] * p.from_unit(posterior.u[s][static_cast<Index>(i)]);
  for (std::size_t s = 0; s < posterior.u.size(); ++s)
    square += posterior.weight[s] *
              std::pow(p.from_unit(posterior.u[s][static_cast<Index>(i)]) - mean, 2);
  return std::sqrt(square);
}

std::vector<std::string> materials_of(const Study& study) {
  std::vector<std::string> materials;
  for (const Parameter& p : study.parameters)
    for (const std::string& key : p.keys)
      for (const std::string& m : parse_material_key(key).materials)
        if (std::ranges::find(materials, m) == materials.end()) materials.push_back(m);
  return materials;
}

std::string file_hash(const std::string& file) {
  return sha256(read_input_file(file, "a file to take the hash of", input_limits::raw_data_bytes));
}

void collect(const toml::table& table, const std::string& path, std::vector<std::string>& out) {
  for (const auto& [key, node] : table) {
    const std::string here = fmt::format("{}.{}", path, key.str());
    if (const toml::table* t = node.as_table())
      collect(*t, here, out);
    else if (const auto text = node.value<std::string>())
      out.push_back(fmt::format("{} = {}", here, *text));
    else if (const auto number = node.value<double>())
      out.push_back(fmt::format("{} = {}", here, *number));
  }
}

// Values that the cases held fixed; the estimate is valid for these values only.
std::vector<ScopeLimit> scope_of(const Study& study, const std::vector<SimulatedCase>& cases) {
  std::string tests;
  for (const Target& t : study.targets)
    tests +=
        fmt::format("{}{} = {:.4g} ± {:.2g}{}{}", tests.empty() ? "" : ", ", t.response.label,
                    t.value, t.uncertainty, unit_suffix(t.unit),
                    t.discrepancy > 0 ? fmt::format(" (discrepancy of the simulation ± {:.2g}{})",
                                                    t.discrepancy, unit_suffix(t.unit))
                                      : "");
  std::vector<ScopeLimit> scope = {{"test", fmt::format("fitted to {}", tests)}};
  std::set<std::string> bound;
  for (const Parameter& p : study.parameters) bound.insert(p.keys.begin(), p.keys.end());
  for (const SimulatedCase& c : cases) {
    const toml::table document = toml::parse(c.text);  // as the reader of cases wrote it
    const auto add_scope = [&](const char* name, const char* table) {
      std::vector<std::string> values;
      if (const toml::table* t = document[table].as_table()) collect(*t, table, values);
      std::erase_if(
          values, [&](const std::string& v) { return bound.contains(v.substr(0, v.find(" = "))); });
      if (!values.empty())
        scope.push_back({c.experiment.empty() ? name : fmt::format("{} ({})", name, c.experiment),
                         comma_list(values)});
    };
    add_scope("shape", "shapes");
    add_scope("stiffness and density", "materials");
    add_scope("contact law, held fixed", "interactions");
  }
  return scope;
}

// Commits that the runs' programs were built from: one, as a rule.
std::string commits_of(const std::vector<JournalRun>& runs) {
  std::set<std::string> commits;
  for (const JournalRun& run : runs) commits.insert(run.git_commit);
  commits.erase("");
  return commits.empty() ? firn_git_commit() : comma_list(commits);
}

std::vector<RawData> raw_data_of(const Study& study, const std::string& directory) {
  std::vector<RawData> all;
  const auto keep = [&](const std::string& what, const std::string& file) {
    if (std::ranges::find(all, file, &RawData::file) == all.end())
      all.push_back({what, file, file_hash(file)});
  };
  keep("study", study.source);
  for (const Experiment& e : study.experiments) keep("case", e.case_file);
  for (const Target& t : study.targets)
    if (!t.file.empty()) keep("measurement", t.file);
  keep("responses of every run", (fs::path(directory) / "runs.csv").string());
  return all;
}

Provenance provenance_of(const Study& study, const std::vector<JournalRun>& runs,
                         const std::string& directory) {
  Provenance p;
  p.date = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
  p.source = fmt::format("study {} ({}), calibrated with firn {}", study.name, study.source,
                         firn_version());
  p.study = study.name;
  p.program_version = firn_version();
  p.program_commit = commits_of(runs);
  p.program = program_identity();
  p.contact_model = kContactModel;
  p.raw_data = raw_data_of(study, directory);
  for (const Target& t : study.targets) {
    UsedMeasurement m{"", t.response.label, t.value, t.uncertainty, stored_unit(t.unit), t.source,
                      ""};
    m.discrepancy = t.discrepancy;
    if (!t.file.empty()) {
      const Measurement read = read_measurement(t.file);
      m.name = read.name;
      m.experiment = read.experiment;
      m.source = fmt::format("{} ({})", read.source, t.file);
    } else {
      m.source = fmt::format("{} ({})", t.source, study.source);
    }
    p.measurements.push_back(m);
  }
  std::set<std::uint64_t> seeds;
  std::set<std::string> known;
  for (const JournalRun& run : runs) {
    seeds.insert(run.label.seed);
    for (const MaterialResponse& wanted : responses_of(study, run))
      for (const Response& r : run.result.responses)
        if (r.name == wanted.name && known.insert(r.name).second)
          p.estimators.push_back({r.name, r.method, r.method_version});
  }
  p.seeds.assign(seeds.begin(), seeds.end());
  p.command = fmt::format("firn calibrate {} -o {}", study.source, directory);
  return p;
}

// Each experiment at these values, with the first seed that was run there.
std::vector<SimulatedCase> cases_of(const Study& study, const ReferenceSet& reference,
                                    Executor& executor) {
  std::vector<SimulatedCase> cases;
  for (const Experiment& e : study.experiments) {
    const auto run = std::ranges::find(reference.runs, e.name, &ReferenceRun::experiment);
    const std::uint64_t seed = run == reference.runs.end() ? study.seed : run->seed;
    SimulatedCase c{
        e.name,
        {},
        executor.resolve(e.case_file, overrides_of(study, e, reference.values, seed), {}).text};
    for (std::size_t i = 0; i < study.parameters.size(); ++i)
      if (e.takes[i]) c.parameters.push_back(study.parameters[i].name);
    cases.push_back(c);
  }
  return cases;
}

}  // namespace

void require_material(const Study& study) {
  if (!study.curves.empty())
    throw InputError(
        fmt::format("{}: targets: {} is a curve, which a material record cannot hold; expected "
                    "targets with a value alone",
                    study.source, study.curves.front().label));
  if (study.choice)
    throw InputError(
        fmt::format("{}: parameters: {} has choices, which a material record cannot hold; expected "
                    "parameters with ranges alone",
                    study.source, study.choice->name));
  for (const Experiment& e : study.experiments)
    if (e.program)
      throw InputError(
          fmt::format("{}: experiments: {} is a program of the user, whose parameters are no "
                      "properties of Firn's materials; expected cases alone for a material record",
                      study.source, e.name));
  for (const Parameter& p : study.parameters)
    for (const std::string& key : p.keys) {
      try {
        parse_material_key(key);
      } catch (const InputError& e) {
        throw InputError(fmt::format("{}: parameters: {}: {}", study.source, p.name, e.what()));
      }
    }
  if (const auto materials = materials_of(study); materials.size() > 2)
    throw InputError(
        fmt::format("{}: parameters: are about {}; expected one material or a pair in a record",
                    study.source, comma_list(materials)));
}

PosteriorEnsemble posterior_ensemble(const Study& study, const CalibrationResult& result,
                                     const std::vector<JournalRun>& runs, Executor& executor) {
  PosteriorEnsemble ensemble;
  fill_moments(study, *result.posterior, ensemble);
  ensemble.samples = thinned(study, *result.posterior);
  for (const Combination& c : result.combinations) {
    EnsembleCombination kept;
    kept.coefficients.assign(c.coefficients.begin(), c.coefficients.end());
    kept.identifiable = c.identifiable;
    if (c.identifiable) {
      kept.value = c.value;
      if (std::isfinite(c.uncertainty())) kept.uncertainty = c.uncertainty();
    }
    ensemble.combinations.push_back(kept);
  }
  ensemble.reference_sets.push_back(reference_set_of(study, result.best, "answer", runs, executor));
  for (const CheckedSet& member : result.ridge)
    ensemble.reference_sets.push_back(reference_set_of(study, member, member.name, runs, executor));
  return ensemble;
}

MaterialRecord material_record(const Study& study, const CalibrationResult& result,
                               const std::vector<JournalRun>& runs, Executor& executor,
                               const std::string& directory, const RecordOptions& label) {
  if (result.verdict != StudyVerdict::calibrated &&
      result.verdict != StudyVerdict::not_identifiable)
    throw InputError(
        fmt::format("material {}: not saved, because the study is {}: {}; expected an answer that "
                    "was confirmed",
                    label.name, to_string(result.verdict), result.headline));
  require_material(study);
  MaterialRecord record;
  record.name = label.name;
  record.title = fmt::format("Fitted by the study {}", study.name);
  record.materials = materials_of(study);
  record.kind = RecordKind::calibrated;
  for (std::size_t i = 0; i < study.parameters.size(); ++i) {
    const Parameter& p = study.parameters[i];
    const Marginal& m = result.posterior->marginals[i];
    record.parameters.push_back({p.name, p.keys, result.best.values[i], stored_unit(p.unit),
                                 standard_deviation(p, *result.posterior, i),
                                 Interval{m.low, m.high}, ""});
  }
  record.ensemble = posterior_ensemble(study, result, runs, executor);
  record.provenance = provenance_of(study, runs, directory);
  record.provenance.author = label.author;
  record.provenance.cases = cases_of(study, record.ensemble->reference_sets.front(), executor);
  record.scope = scope_of(study, record.provenance.cases);
  record.scope.insert(record.scope.end(), label.scope.begin(), label.scope.end());
  record.note = result.headline;
  if (result.fidelity)
    record.note += fmt::format(
        ". {} of {} runs were of a low fidelity, whose bias the study estimated: see its file",
        result.fidelity->low.count, result.fidelity->low.count + result.fidelity->high.count);
  if (!label.note.empty()) record.note += ". " + label.note;
  return record;
}

}  // namespace firn
