// firn optimize: the design with the best response within limits of what may go wrong.
#include <fmt/core.h>

#include <memory>

#include "app/batch_commands/commands.h"
#include "app/support/batch_options.h"
#include "app/support/batch_result.h"
#include "app/support/exit_status.h"
#include "calibrate/optimization/optimize_design.h"

namespace firn {
namespace {

struct OptimizeArguments {
  BatchArguments batch;
  std::string file;
};

int run_optimization(const OptimizeArguments& a) {
  OptimizationOptions options;
  options.file = a.file;
  apply(a.batch, options);
  const OptimizationResult r = optimize_design(options);
  if (r.verdict == OptimizationVerdict::interrupted) return report_interruption(r.directory);
  print_batch_result(a.batch, r, fmt::format("Every run is in {}/runs.csv", r.directory));
  return r.verdict == OptimizationVerdict::too_few_runs ? ExitStatus::failed : ExitStatus::done;
}

}  // namespace

void add_optimize_command(CLI::App& app, int& status) {
  auto a = std::make_shared<OptimizeArguments>();
  CLI::App* command =
      app.add_subcommand("optimize", "Search for the design with the best response within limits");
  command
      ->add_option("FILE.toml", a->file,
                   "The optimization: case, design parameters, what to maximize, limits, runs")
      ->required()
      ->type_name("");
  add_batch_options(*command, a->batch, "optimization");
  command->callback([a, &status] { status = run_optimization(*a); });
}

}  // namespace firn
