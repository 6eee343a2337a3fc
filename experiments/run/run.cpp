#include "experiments/run/run.h"

#include <fmt/format.h>

#include <memory>
#include <optional>

#include "experiments/case_reader/case_from_results.h"
#include "experiments/responses/measure.h"
#include "experiments/results/checkpoint.h"
#include "experiments/results/recorder.h"
#include "experiments/results/results_file.h"
#include "experiments/results/results_schema.h"
#include "experiments/results/results_writer.h"
#include "experiments/run/driver.h"
#include "experiments/run/interference_check.h"
#include "experiments/system/interruption.h"
#include "firn/contact_model.h"

namespace firn {
namespace {

using Lock = Recorder::Lock;

// Measures the finished file of case `c` and writes the responses into it.
std::vector<Response> measure_and_store(const Lock& lock, const Case& c) {
  std::vector<Response> responses = measure(Recording(lock->file()), c);
  Recorder recorder = Recorder::reopen(lock, {});
  recorder.with_file([&](hdf5::File& file) {
    if (file.contains("/responses")) file.remove("/responses");  // a part, from before a kill
    write_responses(file, responses);
    file.flush();
    file.set_attribute("/", "responses_complete", std::uint64_t{1});  // all of them are there
  });
  recorder.close();
  return responses;
}

// Whether nothing is left to do for a finished run. One that was killed just as it finished may
// have left its checkpoints, or not been measured.
bool is_complete(const std::string& results_file) {
  const hdf5::File file = results::open_file(results_file, hdf5::File::Access::read);
  return !has_saved_copy(results_file) && file.has_attribute("/", "responses_complete") &&
         file.contains("/responses") && !file.contains("/checkpoint");
}

std::vector<Response> complete_finished_run(const Lock& lock) {
  lock->save_copy();
  Recorder recorder = Recorder::reopen(lock, {});
  recorder.with_file([](hdf5::File& file) { remove_checkpoints(file); });
  recorder.close();
  const Case c = read_case(Recording(lock->file()));
  std::vector<Response> responses = measure_and_store(lock, c);
  lock->remove_copy();
  return responses;
}

RunSummary write_failure(const WriteError& e, const std::string& safe) {
  RunSummary summary;
  summary.reason = WriteError(e, safe).what();
  summary.write_failed = true;
  return summary;
}

RunObserver run_observer(const RunOptions& options) {
  if (!options.each_step) return {};
  RunObserver looks;
  looks.step = [&options](const Solver& solver, bool last) {
    options.each_step(solver, last);
    return true;
  };
  return looks;
}

// The copy of the last checkpoint stays until the file is complete.
RunSummary drive(Driver& driver, const Lock& lock, const Case& c) {
  RunSummary summary;
  try {
    summary = driver.run();
    if (!driver.concluded()) return summary;
    if (summary.status == RunStatus::finished) summary.responses = measure_and_store(lock, c);
    lock->remove_copy();
  } catch (const WriteError& e) {
    summary.status = RunStatus::failed;
    summary.reason = WriteError(e, driver.recovery_hint(e)).what();
    summary.write_failed = true;
  } catch (const InputError&) {
    if (driver.concluded()) lock->remove_copy();
    throw;
  }
  return summary;
}

// Throws InputError as case_of() does.
void require_contact_model(const Recording& recording, const char* what) {
  if (const int made_with = recording.contact_model(); made_with != kContactModel)
    throw InputError(fmt::format(
        "{}: cannot be {}: it was made with contact model {}, and this build has {}; run the case "
        "again",
        recording.file(), what, made_with, kContactModel));
}

void require_case_of(const Recording& recording, const Case& c, const char* what) {
  require_contact_model(recording, what);
  if (c.model.timestep != recording.timestep() || c.seed != recording.seed() ||
      c.model.particles.size() != recording.particle_count())
    throw InputError(
        fmt::format("{}: cannot be {}: this version of Firn reads another case from it",
                    recording.file(), what));
}

}  // namespace

Case case_of(const Recording& recording, const char* what) {
  require_contact_model(recording, what);  // before the case of another version is read
  Case c = read_case(recording);
  require_case_of(recording, c, what);
  return c;
}

std::string stage_text(const Progress& p) {
  std::string text =
      fmt::format("{}, {} particle{}", p.stage, p.present, p.present == 1 ? "" : "s");
  if (p.waiting > 0) text += fmt::format(", {} to come", p.waiting);
  if (p.left > 0) text += fmt::format(", {} left", p.left);
  for (const Progress::Passed& sensor : p.passed)
    if (sensor.count > 0) text += fmt::format(", {} through {}", sensor.count, sensor.sensor);
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
  check_machine(c);
  std::string renamed_earlier_file;
  Lock lock;
  std::optional<Recorder> recorder;
  RunSummary summary;
  try {
    renamed_earlier_file =
        rename_earlier_results(options.results_file);  // a killed run is kept whole, too
    std::optional<interruption::Uninterrupted> created(std::in_place);
    lock = std::make_shared<ResultsLock>(options.results_file);
    interruption::Temporary unsaved[] = {interruption::Temporary(options.results_file),
                                         interruption::Temporary(saved_copy(options.results_file))};
    created.reset();
    recorder.emplace(Recorder::create(lock, result_columns(c)));
    recorder->with_file([&](hdf5::File& file) {
      write_header(file, c);
      file.flush();
    });
    Driver driver(c, options, &*recorder, run_observer(options));
    driver.set_unsaved(unsaved);
    if (options.started) options.started();
    summary = drive(driver, lock, c);
  } catch (const WriteError& e) {
    summary = write_failure(
        e, fmt::format("nothing was simulated: {}start the run again", remedy(e.error)));
  }
  summary.renamed_earlier_file = renamed_earlier_file;
  return summary;
}

RunSummary resume(const std::string& results_file, const RunOptions& given, const Case* known) {
  RunOptions options = given;
  options.results_file = results_file;
  const auto finished = [&](std::vector<Response> responses) {
    if (options.started) options.started();
    RunSummary summary;
    summary.status = RunStatus::finished;
    summary.reason = "was finished already";
    const std::vector<double> times = Recording(results_file).frame_times();
    summary.simulated = times.empty() ? 0 : times.back();
    summary.responses = std::move(responses);
    return summary;
  };
  if (!has_saved_copy(results_file)) {
    const Recording recording(results_file);  // says what is wrong with the name
    if (recording.status() == "finished" && is_complete(results_file))
      return finished(recording.responses());
  }
  const auto lock = std::make_shared<ResultsLock>(results_file);
  try {
    const bool restored = recover_results(*lock);
    std::optional<Case> read;
    bool unfinished = false;
    {
      const Recording recording(results_file);
      unfinished = recording.status() != "finished";
      if (unfinished) {
        if (known == nullptr)
          known = &read.emplace(case_of(recording, "resumed"));
        else
          require_case_of(recording, *known, "resumed");
        if (!recording.has_checkpoint())  // before a copy of it would be taken for the truth
          throw InputError(
              fmt::format("{}: cannot be resumed: it has no whole checkpoint", results_file));
      }
    }
    if (!unfinished) return finished(complete_finished_run(lock));
    const Case& c = *known;
    if (!restored) lock->save_copy();
    Recorder recorder = Recorder::reopen(lock, result_columns(c));
    Driver driver(c, options, &recorder, run_observer(options));
    try {
      driver.restore();
      recorder.with_file(
          [](hdf5::File& file) { file.set_attribute("/", "status", std::string("running")); });
    } catch (const WriteError& e) {
      return write_failure(e, driver.recovery_hint(e));
    }
    if (options.started) options.started();
    return drive(driver, lock, c);
  } catch (const WriteError& e) {
    return write_failure(
        e, fmt::format("its last state is safe in {}: {}continue with firn run --resume {}",
                       has_saved_copy(results_file) ? saved_copy(results_file) : results_file,
                       remedy(e.error), results_file));
  }
}

}  // namespace firn
