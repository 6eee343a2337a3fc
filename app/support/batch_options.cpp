#include "app/support/batch_options.h"

#include <filesystem>

#include "app/support/exit_status.h"
#include "app/support/known_words.h"
#include "app/support/shared_options.h"
#include "experiments/system/interruption.h"
#include "experiments/system/terminal.h"

namespace firn {

std::string BatchArguments::store_file() const {
  namespace fs = std::filesystem;
  if (no_store) return "";
  if (!store.empty()) return store;
  if (directory.empty()) return (fs::path("runs") / "store.db").string();
  fs::path folder = fs::absolute(directory).lexically_normal();
  if (!folder.has_filename()) folder = folder.parent_path();
  return (folder.parent_path() / "store.db").string();
}

void apply(const BatchArguments& arguments, BatchOptions& options) {
  options.directory = arguments.directory;
  options.jobs = arguments.jobs;
  options.resume = arguments.resume;
  options.executor = arguments.executor;
  options.store = arguments.store_file();
  options.json_progress = arguments.progress == "json";
  options.show_progress = arguments.progress != "none";
  options.interrupt = &interruption::requested();
}

int report_interruption(const std::string& directory) {
  print_lines(stderr, "firn: interrupted; {}\n", resume_hint(directory));
  return ExitStatus::interrupted;
}

void add_batch_options(CLI::App& command, BatchArguments& a, const std::string& what) {
  command
      .add_option("-o,--output", a.directory,
                  "Folder for its journal, runs and results; runs/<" + what + " name> by default")
      ->type_name("DIR");
  command
      .add_option("--jobs", a.jobs,
                  "Simulations that run at the same time; one per core by default")
      ->check(CLI::Range(1, 1024))
      ->type_name("N");
  command
      .add_option(
          "--executor", a.executor,
          "Where the simulations run: on this machine, or on the Slurm\ncluster that it belongs to")
      ->check(one_of({"local", "slurm"}))
      ->capture_default_str();
  CLI::Option* store = command
                           .add_option("--cache", a.store,
                                       "Outcomes shared with other studies, validations, sweeps "
                                       "and optimizations; by default "
                                       "store.db in the parent folder")
                           ->type_name("FILE");
  command
      .add_flag("--no-cache", a.no_store,
                "Neither take outcomes from the file of --cache nor add any")
      ->excludes(store);
  command.add_flag("--resume", a.resume,
                   "Fail when the folder does not hold this " + what +
                       ". Without it, finished runs in the folder are also taken");
  command
      .add_option("--progress", a.progress,
                  "On standard error: text with a bar, a JSON object a line for each event, or "
                  "nothing")
      ->check(one_of({"text", "json", "none"}))
      ->capture_default_str();
  command.add_flag("--json", a.json, json_help);
}

}  // namespace firn
