// firn validate: simulation against experiment.
#include <fmt/core.h>

#include <filesystem>
#include <memory>

#include "app/commands.h"
#include "app/exit_status.h"
#include "app/interrupt.h"
#include "validation/validate.h"

namespace firn {
namespace {

struct Arguments {
  ValidationOptions options;
  std::string store, progress = "people", require;
  bool no_store = false, json = false;
};

// Whether the verdicts are what --require asks for.
bool requirement_met(const Arguments& a, const Validation& v) {
  if (a.require.empty()) return true;
  const int wrong = v.count(ValidationVerdict::inconsistent);
  const int open = v.count(ValidationVerdict::not_enough_data);
  return wrong == 0 && (a.require == "none-inconsistent" || open == 0);
}

int run_suite(const Arguments& a) {
  ValidationOptions options = a.options;
  namespace fs = std::filesystem;
  if (!a.no_store) {
    fs::path folder = fs::absolute(options.directory.empty() ? fs::path("runs") / "x"
                                                             : fs::path(options.directory))
                          .lexically_normal();
    if (!folder.has_filename()) folder = folder.parent_path();
    options.store = a.store.empty() ? (folder.parent_path() / "store.db").string() : a.store;
  }
  options.json_progress = a.progress == "json";
  options.show_progress = a.progress != "none";
  options.interrupt = &interrupt_flag();
  const Validation v = validate(options);
  if (v.interrupted) {
    fmt::print(stderr,
               "firn: interrupted; everything finished is kept in {}: the same command goes on "
               "from there\n",
               v.directory);
    return ExitStatus::interrupted;
  }
  fmt::print("{}{}", a.json ? render_json(v) : render_table(v), a.json ? "\n" : "");
  if (!a.json) fmt::print(stderr, "Everything about this validation is in {}\n", v.directory);
  return requirement_met(a, v) ? ExitStatus::done : ExitStatus::requirement_missed;
}

}  // namespace

void add_validate_command(CLI::App& app, int& status) {
  auto a = std::make_shared<Arguments>();
  ValidationOptions* options = &a->options;
  CLI::App* command = app.add_subcommand(
      "validate", "Compare simulations with experiments, with both uncertainties, and judge");
  command
      ->add_option("SUITE.toml", options->suite_file,
                   "The suite: parameter sets, experiments, comparisons")
      ->required()
      ->type_name("");
  command
      ->add_option("-o,--output", options->directory,
                   "Folder for its journal, runs and results; runs/<suite name> by default")
      ->type_name("DIR");
  command
      ->add_option("--material", options->material,
                   "A material record in place of the suite's parameter sets")
      ->type_name("NAME[@VERSION]");
  command
      ->add_option("--database", options->database, "File of material records; docs/materials.md")
      ->type_name("FILE");
  command->add_option("--jobs", options->jobs, "Simulations side by side; one per core by default")
      ->check(CLI::Range(1, 1024))
      ->type_name("N");
  command
      ->add_option("--executor", options->executor,
                   "Who simulates: this machine, or the cluster it belongs to")
      ->check(CLI::IsMember({"local", "slurm"}))
      ->capture_default_str();
  CLI::Option* store =
      command
          ->add_option("--store", a->store,
                       "Outcomes shared with studies and other suites; store.db beside the folder "
                       "by default")
          ->type_name("FILE");
  command->add_flag("--no-store", a->no_store, "Share no outcomes")->excludes(store);
  command->add_flag("--resume", options->resume,
                    "Insist on going on: fail when the folder does not hold this validation. "
                    "Without it a suite goes on too where its folder has finished runs");
  command
      ->add_option("--require", a->require,
                   "Leave with status 3 unless no verdict is \"inconsistent\", or all are "
                   "\"consistent\"")
      ->check(CLI::IsMember({"none-inconsistent", "all-consistent"}))
      ->type_name("RULE");
  command
      ->add_option("--progress", a->progress,
                   "On standard error: a bar for people, a JSON object a line for each event, or "
                   "nothing")
      ->check(CLI::IsMember({"people", "json", "none"}))
      ->capture_default_str();
  command->add_flag("--json", a->json, "Print JSON on standard output and nothing else");
  command->callback([a, &status] { status = run_suite(*a); });
}

}  // namespace firn
