// firn calibrate: parameters from measurements.
#include <fmt/core.h>

#include <filesystem>
#include <memory>

#include "app/commands.h"
#include "app/interrupt.h"
#include "calibrate/study.h"
#include "reports/heap_picture.h"

namespace firn {
namespace {

// The heap of a run at the answer, beside the results. A study of another experiment has none.
void draw_example(const StudySummary& summary) {
  if (summary.example_run.empty()) return;
  try {
    const Recording recording(summary.example_run);
    if (!recording.read_case().drained_repose) return;
    draw_heap(recording, recording.frame_times().size() - 1,
              (std::filesystem::path(summary.directory) / "drained_heap.png").string());
  } catch (const InputError& e) {
    fmt::print(stderr, "firn: no picture of the heap: {}\n", e.what());
  }
}

int run_study(StudyOptions options, bool json) {
  options.interrupt = &interrupt_flag();
  const StudySummary summary = calibrate(options);
  draw_example(summary);
  if (json) {
    fmt::print("{}\n", summary.json);
  } else {
    fmt::print("{}\n\n{}", summary.headline, summary.table);
    fmt::print(stderr, "Everything about this study is in {}\n", summary.directory);
  }
  return summary.exit_status();
}

}  // namespace

void add_calibrate_command(CLI::App& app, int& status) {
  auto options = std::make_shared<StudyOptions>();
  auto json = std::make_shared<bool>(false);
  CLI::App* command = app.add_subcommand("calibrate", "Fit parameters of a case to measurements");
  command
      ->add_option("STUDY.toml", options->study_file,
                   "The study: case, parameters, targets, budget")
      ->required()
      ->type_name("");
  command
      ->add_option("-o,--output", options->directory,
                   "Folder for its journal, runs and results; runs/<study name> by default")
      ->type_name("DIR");
  command->add_option("--jobs", options->jobs, "Simulations side by side; one per core by default")
      ->check(CLI::Range(1, 1024))
      ->type_name("N");
  command->add_option("--executor", options->executor, "Who simulates")
      ->check(CLI::IsMember({"local"}))
      ->capture_default_str();
  command->add_flag(
      "--resume", options->resume,
      "Insist on going on: fail when the folder does not hold this study. Without it a "
      "study goes on too where its folder has finished runs");
  command->add_flag("--json", *json, "Print JSON on standard output and nothing else");
  command->callback([options, json, &status] { status = run_study(*options, *json); });
}

}  // namespace firn
