#include "experiments/batch/sweep/sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "experiments/batch/batch_folder.h"
#include "experiments/batch/override_places.h"
#include "experiments/responses/response_expression.h"
#include "experiments/results/response.h"
#include "experiments/system/interruption.h"
#include "experiments/system/text_encoding.h"
#include "experiments/text/csv/csv_writer.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

std::vector<Override> overrides(const Sweep& sweep, std::size_t combination, std::uint64_t seed) {
  std::vector<Override> all = {{"case.seed", std::to_string(seed)}};
  all.insert(all.end(), sweep.set.begin(), sweep.set.end());
  const std::vector<std::string> values = sweep.values(combination);
  for (std::size_t i = 0; i < values.size(); ++i)
    for (const std::string& key : sweep.vary[i].keys) all.emplace_back(key, values[i]);
  return all;
}

std::vector<std::string> materials(const Sweep& sweep, std::size_t combination) {
  std::vector<std::string> all = sweep.materials;
  const std::vector<std::string> values = sweep.values(combination);
  for (std::size_t i = 0; i < values.size(); ++i)
    if (sweep.vary[i].is_material()) all.push_back(values[i]);
  return all;
}

// Where the sweep states an override; empty: nowhere.
OverridePlace place_of(const Sweep& sweep, const Override& o) {
  for (const SweptKey& k : sweep.vary) {
    const auto key = std::ranges::find(k.keys, o.first);
    const auto value = std::ranges::find(k.values, o.second);
    if (key == k.keys.end() || value == k.values.end()) continue;
    return {k.key_places.at(static_cast<std::size_t>(key - k.keys.begin())),
            k.value_places.at(static_cast<std::size_t>(value - k.values.begin()))};
  }
  return place_among(sweep.set, sweep.set_places, o);
}

// Where the sweep states a material record; empty: nowhere.
std::string place_of_material(const Sweep& sweep, const std::string& record) {
  const auto among = [&](const std::vector<std::string>& records,
                         const std::vector<ValuePlace>& places) -> std::string {
    const auto found = std::ranges::find(records, record);
    if (found == records.end()) return {};
    return places.at(static_cast<std::size_t>(found - records.begin())).whole;
  };
  for (const SweptKey& k : sweep.vary)
    if (k.is_material())
      if (std::string place = among(k.values, k.value_places); !place.empty()) return place;
  return among(sweep.materials, sweep.material_places);
}

BatchRun planned_run(const Sweep& sweep, std::size_t combination, std::uint64_t seed,
                     const Batch& batch, const std::string& folder) {
  const std::vector<Override> values = overrides(sweep, combination, seed);
  const RunLabel label{"", "sweep", static_cast<int>(combination), sweep.label(combination), seed};
  BatchRun run = with_override_places(
      sweep.case_file, values, [&](const Override& o) { return place_of(sweep, o); },
      [&] {
        return with_material_places(
            [&](const std::string& record) { return place_of_material(sweep, record); },
            [&] {
              return batch.make(sweep.case_file, values, folder, label,
                                {materials(sweep, combination), ""});
            });
      });
  run.job.threads = sweep.threads;
  run.job.limits = sweep.execution.limits;
  return run;
}

// Throws InputError for a response of the sweep that a finished run does not have.
void require_responses(const Sweep& sweep, const JobResult& run) {
  for (std::size_t i = 0; i < sweep.responses.size(); ++i)
    with_place(sweep.response_places.at(i).whole,
               [&] { evaluate(parse_response_expression(sweep.responses[i]), run.responses); });
}

// What is tabled: as asked for, or every single-valued response of the first run that finished.
void choose_responses(SweepResult& r) {
  const auto finished = std::ranges::find_if(
      r.runs, [](const SweepRun& run) { return run.result.status == JobStatus::finished; });
  r.responses = r.sweep.responses;
  if (finished == r.runs.end()) return;
  if (r.responses.empty())
    for (const Response& response : finished->result.responses)
      if (response.value.size() == 1) r.responses.push_back(response.name);
  for (const std::string& name : r.responses)
    r.units.push_back(unit_of(parse_response_expression(name), finished->result.responses));
}

void read_values(SweepResult& r) {
  for (SweepRun& run : r.runs)
    for (const std::string& name : r.responses) try {
        run.values.push_back(run.result.status == JobStatus::finished
                                 ? evaluate(parse_response_expression(name), run.result.responses)
                                 : kUndefined);
      } catch (const InputError&) {
        // One that a run has only when something came to pass is undefined where it did not.
        run.values.push_back(kUndefined);
      }
}

void write_csv(const SweepResult& r) {
  CsvFile file(r.directory, "runs.csv");
  std::string head;
  for (const SweptKey& k : r.sweep.vary) head += encode::csv_field(k.name) + ",";
  head += "seed,status,wall [s],key";
  for (std::size_t i = 0; i < r.responses.size(); ++i) {
    const std::string unit = i < r.units.size() ? r.units[i] : "";
    head +=
        "," + encode::csv_field(unit.empty() || unit == "1" ? r.responses[i]
                                                            : r.responses[i] + " [" + unit + "]");
  }
  file.line(head);
  for (const SweepRun& run : r.runs) {
    std::string line;
    for (const std::string& label : r.sweep.value_labels(run.combination))
      line += encode::csv_field(label) + ",";
    line += fmt::format("{},{},{},{}", run.seed, to_string(run.result.status), run.result.wall,
                        run.key);
    for (const double v : run.values) line += std::isfinite(v) ? fmt::format(",{}", v) : ",";
    file.line(line);
  }
  file.close();
}

void carry_out(SweepResult& r, const SweepOptions& options) {
  BatchFolder folder(
      r.directory,
      {"sweep", "sweep " + r.sweep.name,
       static_cast<int>(r.sweep.combinations() * r.sweep.seeds.size()), r.sweep.execution.slurm},
      options);
  const interruption::Advice advice(resume_hint(r.directory));
  Batch batch(folder.executor(), folder.journal(), folder.store(), folder.progress(),
              options.interrupt);
  std::vector<BatchRun> runs;
  for (std::size_t c = 0; c < r.sweep.combinations(); ++c)
    for (const std::uint64_t seed : r.sweep.seeds) {
      runs.push_back(planned_run(r.sweep, c, seed, batch, folder.runs()));
      r.runs.push_back({c, seed, runs.back().job.key, {}, {}});
    }
  folder.progress().phase(r.sweep.name);
  try {
    batch.run(runs, [&](const BatchRun&, const JobResult& result) {
      if (result.status == JobStatus::finished) require_responses(r.sweep, result);
    });
  } catch (const BatchInterrupted&) {
    r.interrupted = true;
    return;
  }
  folder.progress().done();
  for (SweepRun& run : r.runs) run.result = batch.outcome(run.key);
  choose_responses(r);
  read_values(r);
  folder.journal().require_in_place();
  write_csv(r);
  write_own_file((fs::path(r.directory) / "results.json").string(), render_json(r) + "\n");
  folder.journal().require_in_place();
}

// runs/<name> without blanks. A folder with blanks, of an earlier version, is resumed if it exists.
std::string default_folder(const std::string& name) {
  const fs::path runs = "runs", as_it_is = runs / name;
  std::error_code unreadable;  // as a name that is too long
  if (fs::is_directory(as_it_is, unreadable)) return as_it_is.string();
  const std::string plain_name = encode::file_name(name);
  return (runs / (plain_name.empty() ? "sweep" : plain_name)).string();
}

}  // namespace

SweepResult sweep(const SweepOptions& options) {
  SweepResult r;
  r.sweep = read_sweep(options.sweep_file);
  r.directory = options.directory.empty() ? default_folder(r.sweep.name) : options.directory;
  with_kept_runs(r.directory, [&] { carry_out(r, options); });
  return r;
}

}  // namespace firn
