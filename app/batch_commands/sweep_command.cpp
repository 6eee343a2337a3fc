// firn sweep: one case over values of its keys and over seeds.
#include <fmt/core.h>

#include <algorithm>
#include <memory>

#include "app/batch_commands/commands.h"
#include "app/support/batch_options.h"
#include "app/support/batch_result.h"
#include "app/support/exit_status.h"
#include "experiments/batch/sweep/sweep.h"

namespace firn {
namespace {

struct SweepArguments {
  BatchArguments batch;
  std::string sweep_file;
};

int run_sweep(const SweepArguments& a) {
  SweepOptions options;
  options.sweep_file = a.sweep_file;
  apply(a.batch, options);
  const SweepResult r = sweep(options);
  if (r.interrupted) return report_interruption(r.directory);
  print_batch_result(a.batch, r, fmt::format("Every run is in {}/runs.csv", r.directory));
  const bool any = std::ranges::any_of(
      r.runs, [](const SweepRun& run) { return run.result.status == JobStatus::finished; });
  return any ? ExitStatus::done : ExitStatus::failed;
}

}  // namespace

void add_sweep_command(CLI::App& app, int& status) {
  auto a = std::make_shared<SweepArguments>();
  CLI::App* command =
      app.add_subcommand("sweep", "Run one case over values of its keys and over seeds");
  command
      ->add_option("SWEEP.toml", a->sweep_file, "The sweep: case, what is varied, responses, seeds")
      ->required()
      ->type_name("");
  add_batch_options(*command, a->batch, "sweep");
  command->callback([a, &status] { status = run_sweep(*a); });
}

}  // namespace firn
