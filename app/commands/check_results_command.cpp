// firn check-results: whether a results file can be read; for this program itself.
#include <fmt/core.h>

#include <memory>

#include "app/commands/commands.h"
#include "app/support/exit_status.h"
#include "experiments/results/results_guard.h"
#include "experiments/results/results_schema.h"
#include "experiments/system/terminal.h"

namespace firn {
namespace {

struct CheckResultsArguments {
  std::string file;
  bool describe = false;
};

int check(const CheckResultsArguments& a) {
  if (a.describe) {
    print_lines(stdout, "{}", results::description());
    return ExitStatus::done;
  }
  guard_results_with("");
  try {
    results::check_file(results::open_file(a.file, hdf5::File::Access::read));
  } catch (const hdf5::Error& e) {
    print_lines(stdout, "{}\n", e.what());
    return ExitStatus::bad_input;
  }
  return ExitStatus::done;
}

}  // namespace

void add_check_results_command(CLI::App& app, int& status) {
  auto a = std::make_shared<CheckResultsArguments>();
  CLI::App* command =
      app.add_subcommand("check-results", "Whether a results file keeps to the schema");
  command->group("");  // nothing that people would type
  command->add_option("RUN.h5", a->file, "Results file of `firn run`")->type_name("");
  command->add_flag("--describe", a->describe, "Print what a results file holds, in Markdown");
  command->callback([a, &status] { status = check(*a); });
}

}  // namespace firn
