#include "experiments/run.h"

#include <fmt/format.h>

#include "experiments/checkpoint.h"
#include "experiments/driver.h"
#include "experiments/interruption.h"
#include "experiments/machine_check.h"
#include "experiments/recorder.h"
#include "experiments/recording.h"
#include "experiments/results_layout.h"

namespace firn {
namespace {

// From the finished file alone, and into it.
std::vector<Response> measure_and_store(const std::string& results_file) {
  std::vector<Response> responses = measure(Recording(results_file));
  Recorder recorder = Recorder::reopen(results_file, {});
  recorder.with_file([&](hdf5::File& file) {
    if (file.contains("/responses")) file.remove("/responses");  // a part, from before a kill
    write_responses(file, responses);
    file.flush();
    file.set_attribute("/", "measured", std::uint64_t{1});  // all of them are there
  });
  recorder.close();
  return responses;
}

// A run that was killed just as it finished may have left its checkpoints, or not been measured.
std::vector<Response> tidy_finished(const std::string& results_file) {
  bool measured = false;
  {
    const hdf5::File file = hdf5::File::open(results_file, hdf5::File::Access::read);
    measured = file.has_attribute("/", "measured") && file.contains("/responses");
    if (measured && !file.contains("/checkpoint")) return Recording(results_file).responses();
  }
  keep_copy(results_file);
  Recorder recorder = Recorder::reopen(results_file, {});
  recorder.with_file(remove_checkpoints);
  recorder.close();
  return measured ? Recording(results_file).responses() : measure_and_store(results_file);
}

Onlooker onlooker(const RunOptions& options) {
  if (!options.each_step) return {};
  Onlooker looks;
  looks.step = [&options](const Solver& solver, bool last) {
    options.each_step(solver, last);
    return true;
  };
  return looks;
}

RunSummary drive(Driver& driver, const RunOptions& options) {
  RunSummary summary = driver.run();
  if (summary.status == RunStatus::finished)
    summary.responses = measure_and_store(options.results_file);
  drop_kept_copy(options.results_file);
  return summary;
}

}  // namespace

void check_runnable(const Case& c) {
  if (c.model.particles.empty())
    throw InputError(c.source + ": particles: none; expected at least one, placed or in a fill");
  validate(c.model);
}

Case case_of(const Recording& recording, const char* what) {
  Case c = recording.read_case();
  if (c.model.timestep != recording.timestep() || c.seed != recording.seed() ||
      c.model.particles.size() != recording.particle_count())
    throw InputError(
        fmt::format("{}: cannot be {}: this version of Firn reads another case from it",
                    recording.file(), what));
  return c;
}

std::string stage_text(const Progress& p) {
  std::string text =
      fmt::format("{}, {} particle{}", p.stage, p.present, p.present == 1 ? "" : "s");
  if (p.waiting > 0) text += fmt::format(", {} to come", p.waiting);
  if (p.left > 0) text += fmt::format(", {} left", p.left);
  for (const Progress::Passed& gate : p.passed)
    if (gate.count > 0) text += fmt::format(", {} through {}", gate.count, gate.gate);
  return text;
}

const char* to_string(RunStatus status) {
  switch (status) {
    case RunStatus::finished:
      return "finished";
    case RunStatus::failed:
      return "failed";
    case RunStatus::interrupted:
      return "interrupted";
  }
  return "unknown";
}

RunSummary run(const Case& c, const RunOptions& options) {
  if (options.results_file.empty()) throw InputError(c.source + ": no results file is named");
  check_runnable(c);
  check_machine(c);
  recover_results(options.results_file);  // a killed run is kept whole, too
  const std::string kept_earlier = keep_earlier_results(options.results_file);
  drop_kept_copy(options.results_file);
  interruption::Temporary unsaved[] = {interruption::Temporary(options.results_file),
                                       interruption::Temporary(kept_copy(options.results_file))};
  Recorder recorder = Recorder::create(options.results_file, result_columns(c.model));
  recorder.with_file([&](hdf5::File& file) {
    write_header(file, c);
    file.flush();
  });
  Driver driver(c, options, &recorder, onlooker(options));
  driver.set_unsaved(unsaved);
  RunSummary summary = drive(driver, options);
  summary.kept_earlier = kept_earlier;
  return summary;
}

RunSummary resume(const std::string& results_file, const RunOptions& given) {
  RunOptions options = given;
  options.results_file = results_file;
  RunSummary summary;
  Case c;
  recover_results(results_file);
  {
    const Recording recording(results_file);
    if (recording.status() == "finished") {
      summary.status = RunStatus::finished;
      summary.reason = "was finished already";
      const std::vector<double> times = recording.frame_times();
      summary.simulated = times.empty() ? 0 : times.back();
    } else {
      c = case_of(recording, "resumed");
    }
  }
  if (summary.status == RunStatus::finished) {
    summary.responses = tidy_finished(results_file);
    drop_kept_copy(results_file);
    return summary;
  }
  keep_copy(results_file);
  Recorder recorder = Recorder::reopen(results_file, result_columns(c.model));
  Driver driver(c, options, &recorder, onlooker(options));
  driver.restore();
  recorder.with_file(
      [](hdf5::File& file) { file.set_attribute("/", "status", std::string("running")); });
  return drive(driver, options);
}

}  // namespace firn
