#include "validation/validate.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "experiments/batch/batch_folder.h"
#include "experiments/batch/override_places.h"
#include "experiments/case_reader/read_case.h"
#include "experiments/material_records/material_database.h"
#include "experiments/system/interruption.h"
#include "experiments/system/output_file.h"
#include "validation/comparison/data_provenance.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
using Purpose = RunGroup::Purpose;

// Overrides of some runs, and where the suite states them.
struct StatedOverrides {
  std::vector<Override> set;
  std::vector<ValuePlace> places;  // [set]
};

// Returns make(overrides), which reads the case of the experiment. Errors in values that the
// suite sets have their place in the suite.
template <class Make>
auto with_overrides(const SuiteExperiment& experiment, const ParameterSet& set, std::uint64_t seed,
                    const StatedOverrides& more, const Make& make) {
  std::vector<Override> all = {{"case.seed", std::to_string(seed)}};
  for (const std::vector<Override>* values : {&experiment.set, &set.set, &more.set})
    all.insert(all.end(), values->begin(), values->end());
  const auto place_of = [&](const Override& o) -> OverridePlace {
    if (std::ranges::count(more.set, o) > 0) return place_among(more.set, more.places, o);
    if (std::ranges::count(set.set, o) > 0) return place_among(set.set, set.set_places, o);
    return place_among(experiment.set, experiment.set_places, o);
  };
  return with_override_places(experiment.case_file, all, place_of, [&] {
    return with_material_places([&](const std::string&) { return set.material_place; },
                                [&] { return make(all); });
  });
}

class Runner {
 public:
  Runner(Suite suite, const ValidationOptions& options)
      : options_(options), suite_(std::move(suite)) {
    find_materials();
    for (std::size_t e = 0; e < suite_.experiments.size(); ++e)
      for (std::size_t p = 0; p < suite_.parameter_sets.size(); ++p)
        if (suite_.experiments[e].runs_with(suite_.parameter_sets[p])) plan(e, p);
  }

  Validation carry_out(const std::string& directory) {
    Validation v;
    v.directory = directory;
    BatchFolder folder(
        directory,
        {"validate", "validation " + suite_.name, largest_total(), suite_.execution.slurm},
        options_);
    const interruption::Advice advice(resume_hint(directory));
    Batch batch(folder.executor(), folder.journal(), folder.store(), folder.progress(),
                options_.interrupt);
    try {
      run(batch, folder);
    } catch (const BatchInterrupted&) {
      v.interrupted = true;
    }
    folder.progress().done();
    if (!v.interrupted) compare_all(v);
    folder.journal().require_in_place();
    v.suite = std::move(suite_);
    v.groups = std::move(groups_);
    return v;
  }

 private:
  void find_materials() {
    std::optional<MaterialDatabase> database;
    for (ParameterSet& p : suite_.parameter_sets) {
      if (p.material.empty()) {
        records_.emplace_back();
        continue;
      }
      if (!database) database.emplace(material_database_file(options_.database));
      records_.emplace_back(
          with_place(p.material_place, [&] { return find(*database, p.material); }));
      p.material = records_.back()->reference();  // the version that is there now
      if (p.samples > 0) require_ensemble(*records_.back(), p.samples_place);
    }
  }

  static MaterialRecord find(const MaterialDatabase& database, const std::string& text) {
    const MaterialChoice choice = parse_material_choice(text);
    if (!choice.selection().empty())
      throw InputError(
          fmt::format("material {}: names a sample; expected NAME or NAME@VERSION here", text));
    return database.find(choice.name, choice.version).record;
  }

  // `place`: of the number of samples in the suite.
  static void require_ensemble(const MaterialRecord& record, const std::string& place) {
    if (!record.ensemble)
      throw InputError(fmt::format("{}: {} has no posterior ensemble to draw from; expected none",
                                   place, record.reference()));
  }

  void add(std::size_t experiment, std::size_t set, Purpose purpose, double setting,
           std::vector<std::uint64_t> seeds, std::size_t number = 0) {
    groups_.push_back({experiment, set, purpose, setting, std::move(seeds), {}, {}, number});
  }

  void plan(std::size_t e, std::size_t p) {
    const SuiteExperiment& experiment = suite_.experiments[e];
    const ParameterSet& set = suite_.parameter_sets[p];
    const Case base =
        with_overrides(experiment, set, 1, {}, [&](const std::vector<Override>& overrides) {
          return read_case(experiment.case_file, overrides, {request(set, {}), options_.database});
        });
    find_same_values(e, p, base);
    add(e, p, Purpose::base, 0, experiment.seeds);
    if (const int samples = experiment.samples.value_or(set.samples);
        samples > 0 && !set.material.empty() && has_value(e)) {
      if (experiment.samples) require_ensemble(*records_[p], experiment.samples_place);
      // Other draws, other seeds: what seeds do is taken out of their scatter.
      std::vector<std::uint64_t> seeds;
      seeds.reserve(static_cast<std::size_t>(samples));
      for (int k = 0; k < samples; ++k)
        seeds.push_back(experiment.seeds.front() + static_cast<std::uint64_t>(k));
      add(e, p, Purpose::input, 0, seeds);
    }
    if (p == first_set(e)) plan_numerics(e, p, base);
  }

  // Runs with other time steps, stiffnesses and variants.
  void plan_numerics(std::size_t e, std::size_t p, const Case& base) {
    const SuiteExperiment& experiment = suite_.experiments[e];
    const Refinement& refine = experiment.refine;
    if (!refine.material.empty()) {
      const auto found = std::ranges::find(base.model.materials, refine.material, &Material::name);
      if (found == base.model.materials.end())
        throw InputError(fmt::format("{}: \"{}\" is not a material of the case; expected one",
                                     refine.material_place, refine.material));
      base_modulus_[e] = found->young_modulus;
    }
    for (std::size_t k = 0; k < refine.timesteps.size(); ++k)
      add(e, p, Purpose::timestep, base.model.timestep * refine.timesteps[k], refine.seeds, k);
    std::vector<std::size_t> ascending(refine.stiffness.size());
    std::iota(ascending.begin(), ascending.end(), std::size_t{0});
    std::ranges::sort(ascending, {}, [&](std::size_t k) { return refine.stiffness[k]; });
    for (const std::size_t k : ascending)
      add(e, p, Purpose::stiffness, refine.stiffness[k], refine.seeds, k);
    for (std::size_t k = 0; k < experiment.variants.size(); ++k)
      add(e, p, Purpose::variant, 0, experiment.variants[k].seeds, k);
  }

  // Values without a record, or in addition to one, may equal those of a calibrated record.
  void find_same_values(std::size_t e, std::size_t p, const Case& base) {
    if (!calibrated_) {
      calibrated_.emplace();
      const MaterialDatabase database(material_database_file(options_.database));
      for (const std::string& name : database.names())
        for (StoredRecord& stored : database.history(name))
          if (stored.record.kind == RecordKind::calibrated)
            calibrated_->push_back(std::move(stored.record));
    }
    for (std::size_t k = 0; k < calibrated_->size(); ++k)
      if (has_values_of((*calibrated_)[k], values_in_case((*calibrated_)[k], base.resolved)))
        same_values_[{e, p}].push_back(k);
  }

  // Effects of numerics are evaluated with the first parameter set of an experiment.
  std::size_t first_set(std::size_t experiment) const {
    const auto& sets = suite_.parameter_sets;
    const auto found = std::ranges::find_if(
        sets, [&](const ParameterSet& p) { return suite_.experiments[experiment].runs_with(p); });
    return static_cast<std::size_t>(found - sets.begin());
  }

  // Only comparisons of values have a place for the uncertainty of the input.
  bool has_value(std::size_t experiment) const {
    return std::ranges::any_of(suite_.comparisons, [&](const SuiteComparison& c) {
      return c.experiment == experiment && c.kind == ComparisonKind::value;
    });
  }

  static std::vector<std::string> request(const ParameterSet& set, std::optional<int> sample) {
    if (set.material.empty()) return {};
    return {sample ? fmt::format("{}#{}", set.material, *sample) : set.material};
  }

  StatedOverrides numerics(const RunGroup& group) const {
    const SuiteExperiment& experiment = suite_.experiments[group.experiment];
    const Refinement& refine = experiment.refine;
    if (group.purpose == Purpose::timestep)
      return {{{"case.timestep", fmt::format("\"{} s\"", group.setting)}},
              {refine.timestep_places.at(group.number)}};
    if (group.purpose == Purpose::stiffness)
      return {{{fmt::format("materials.{}.young_modulus", refine.material),
                fmt::format("\"{} Pa\"", group.setting)}},
              {refine.stiffness_places.at(group.number)}};
    if (group.purpose == Purpose::variant) {
      const Variant& variant = experiment.variants[group.number];
      return {variant.set, variant.set_places};
    }
    return {};
  }

  int largest_total() const {
    std::size_t runs = 0;
    for (const RunGroup& group : groups_) runs += group.seeds.size();
    return static_cast<int>(runs);
  }

  // All runs in one batch: the cheapest way to keep every core busy.
  void run(Batch& batch, BatchFolder& folder) {
    std::vector<BatchRun> runs;
    for (RunGroup& group : groups_) {
      const SuiteExperiment& experiment = suite_.experiments[group.experiment];
      const ParameterSet& set = suite_.parameter_sets[group.parameter_set];
      int sample = 0;
      for (const std::uint64_t seed : group.seeds) {
        std::optional<int> draw;
        if (group.purpose == Purpose::input) draw = ++sample;
        BatchRun next = with_overrides(
            experiment, set, seed, numerics(group), [&](const std::vector<Override>& overrides) {
              return batch.make(experiment.case_file, overrides, folder.runs(),
                                {experiment.name, to_string(group.purpose), sample, set.name, seed},
                                {request(set, draw), options_.database});
            });
        next.job.threads = suite_.threads;
        next.job.limits = suite_.execution.limits;
        group.keys.push_back(next.job.key);
        runs.push_back(std::move(next));
      }
    }
    folder.progress().phase(suite_.name);
    batch.run(runs, [&](const BatchRun& one, const JobResult& result) {
      if (result.status == JobStatus::finished) require_responses_of(one.job.key, result);
    });
    for (RunGroup& group : groups_)
      for (const std::string& key : group.keys) group.results.push_back(batch.outcome(key));
  }

  // Of the comparisons that read this run. The first run decides, not the last.
  void require_responses_of(const std::string& key, const JobResult& run) const {
    for (const RunGroup& group : groups_) {
      if (group.purpose != Purpose::base && group.purpose != Purpose::input) continue;
      if (std::ranges::find(group.keys, key) == group.keys.end()) continue;
      for (const SuiteComparison& comparison : suite_.comparisons)
        if (comparison.experiment == group.experiment) require_responses(comparison, run);
    }
  }

  ComparisonRuns evidence(std::size_t experiment, std::size_t set) const {
    ComparisonRuns e;
    for (const RunGroup& group : groups_) {
      if (group.experiment != experiment) continue;
      // These exist for the first parameter set only; what they show is taken over to the others.
      if (group.purpose == Purpose::timestep) {
        e.timestep = &group;  // the finest comes last
        e.timesteps.push_back(&group);
      }
      if (group.purpose == Purpose::stiffness) e.stiffness.push_back(&group);
      if (group.purpose == Purpose::variant)
        e.variants.push_back({&suite_.experiments[experiment].variants[group.number], &group});
      if (group.purpose == Purpose::base && group.parameter_set == first_set(experiment))
        e.numerics_base = &group;
      if (group.parameter_set != set) continue;
      if (group.purpose == Purpose::base) e.base = &group;
      if (group.purpose == Purpose::input) e.input = &group;
    }
    const auto modulus = base_modulus_.find(experiment);
    e.base_modulus = modulus == base_modulus_.end() ? 0 : modulus->second;
    if (records_[set]) e.material = &*records_[set];
    if (const auto same = same_values_.find({experiment, set}); same != same_values_.end())
      for (const std::size_t k : same->second) e.same_values.push_back(&(*calibrated_)[k]);
    return e;
  }

  void compare_all(Validation& v) const {
    for (const SuiteComparison& what : suite_.comparisons)
      for (std::size_t p = 0; p < suite_.parameter_sets.size(); ++p) {
        if (!suite_.experiments[what.experiment].runs_with(suite_.parameter_sets[p])) continue;
        // Effects of numerics, evaluated with the first set.
        if (!measures(what.kind) && p != first_set(what.experiment)) continue;
        v.comparisons.push_back(
            compare(suite_, what, suite_.parameter_sets[p], evidence(what.experiment, p)));
      }
  }

  const ValidationOptions& options_;
  Suite suite_;
  std::vector<std::optional<MaterialRecord>> records_;     // by parameter set
  std::optional<std::vector<MaterialRecord>> calibrated_;  // all that the database has
  std::map<std::pair<std::size_t, std::size_t>, std::vector<std::size_t>> same_values_;
  std::map<std::size_t, double> base_modulus_;  // by experiment
  std::vector<RunGroup> groups_;
};

}  // namespace

int Validation::count(ValidationVerdict verdict) const {
  return static_cast<int>(std::ranges::count_if(
      comparisons, [&](const Comparison& c) { return c.verdict == verdict && !c.code_to_code; }));
}

Validation validate(const ValidationOptions& options) {
  Suite suite = read_suite(options.suite_file);
  if (!options.material.empty()) {
    ParameterSet set{options.material, "", options.material, {}, 0};
    for (const ParameterSet& p : suite.parameter_sets)
      if (p.samples > set.samples) {
        set.samples = p.samples;
        set.samples_place = p.samples_place;
      }
    suite.parameter_sets = {set};
    for (SuiteExperiment& e : suite.experiments) e.parameter_sets.clear();
  }
  const std::string directory =
      options.directory.empty() ? (fs::path("runs") / suite.name).string() : options.directory;
  return with_kept_runs(directory, [&] {
    Validation v = Runner(std::move(suite), options).carry_out(directory);
    v.command = fmt::format("firn validate {}{}", options.suite_file,
                            options.material.empty() ? "" : " --material " + options.material);
    if (!v.interrupted) write_own_file(fs::path(directory) / "results.json", render_json(v) + "\n");
    return v;
  });
}

}  // namespace firn
