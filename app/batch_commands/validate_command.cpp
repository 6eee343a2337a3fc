// firn validate: simulation against experiment.
#include <fmt/core.h>

#include <memory>

#include "app/batch_commands/commands.h"
#include "app/support/batch_options.h"
#include "app/support/batch_result.h"
#include "app/support/exit_status.h"
#include "app/support/known_words.h"
#include "app/support/shared_options.h"
#include "validation/validate.h"

namespace firn {
namespace {

struct ValidateArguments {
  ValidationOptions options;
  BatchArguments batch;
  std::string require;
};

// Whether the verdicts satisfy --require.
bool requirement_met(const ValidateArguments& a, const Validation& v) {
  if (a.require.empty()) return true;
  const int wrong = v.count(ValidationVerdict::inconsistent);
  const int open = v.count(ValidationVerdict::inconclusive);
  return wrong == 0 && (a.require == "none-inconsistent" || open == 0);
}

int run_suite(const ValidateArguments& a) {
  ValidationOptions options = a.options;
  apply(a.batch, options);
  const Validation v = validate(options);
  if (v.interrupted) return report_interruption(v.directory);
  print_batch_result(a.batch, v,
                     fmt::format("Everything about this validation is in {}", v.directory));
  return requirement_met(a, v) ? ExitStatus::done : ExitStatus::requirement_missed;
}

}  // namespace

void add_validate_command(CLI::App& app, int& status) {
  auto a = std::make_shared<ValidateArguments>();
  ValidationOptions* options = &a->options;
  CLI::App* command = app.add_subcommand(
      "validate", "Compare simulations with experiments, with both uncertainties");
  command
      ->add_option("SUITE.toml", options->suite_file,
                   "The suite: parameter sets, experiments, comparisons")
      ->required()
      ->type_name("");
  command
      ->add_option("--material", options->material,
                   "Material record whose values replace the parameter sets of the\nsuite")
      ->type_name("NAME[@VERSION]");
  command->add_option("--database", options->database, database_help)->type_name("FILE");
  command
      ->add_option("--require", a->require,
                   "Leave with status 3 unless no verdict is \"inconsistent\", or all are "
                   "\"consistent\"")
      ->check(one_of({"none-inconsistent", "all-consistent"}))
      ->type_name("RULE");
  add_batch_options(*command, a->batch, "validation");
  command->callback([a, &status] { status = run_suite(*a); });
}

}  // namespace firn
