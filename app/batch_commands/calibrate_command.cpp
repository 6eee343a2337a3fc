// firn calibrate: parameters from measurements.
#include <fmt/core.h>
#include <pwd.h>
#include <unistd.h>

#include <filesystem>
#include <memory>

#include "app/batch_commands/commands.h"
#include "app/support/batch_options.h"
#include "app/support/exit_status.h"
#include "app/support/report_page.h"
#include "app/support/shared_options.h"
#include "calibrate/calibrate.h"
#include "calibrate/output/study_comparison.h"
#include "experiments/batch/batch_folder.h"
#include "experiments/batch/execution/execution_settings.h"
#include "experiments/batch/slurm/slurm_executor.h"
#include "experiments/case_reader/case_from_results.h"
#include "experiments/material_records/material_database.h"
#include "experiments/system/interruption.h"
#include "experiments/system/terminal.h"
#include "experiments/text/units.h"
#include "reports/documents/study_estimate.h"
#include "reports/rendering/heap_picture.h"

namespace firn {
namespace {

// Draws the heap of a run at the estimate into the folder of the results. Studies of other
// experiments have no heap.
void draw_example(const StudySummary& summary) {
  if (summary.example_run.empty()) return;
  try {
    const Recording recording(summary.example_run);
    if (!read_case(recording).drained_repose) return;
    const std::string picture =
        (std::filesystem::path(summary.directory) / "drained_heap.png").string();
    with_kept_runs(summary.directory,
                   [&] { draw_heap(recording, recording.frame_times().size() - 1, picture); });
  } catch (const OutputPathError& e) {
    throw WriteError(summary.directory, e.error);
  } catch (const InputError& e) {
    print_lines(stderr, "firn: no picture of the heap: {}\n", e.what());
  }
}

// Two finished studies side by side.
int compare(const std::vector<std::string>& folders, bool json) {
  const StudyComparison c = compare_studies(folders[0], folders[1]);
  print_lines(stdout, "{}{}", json ? comparison_json(c) : comparison_table(c), json ? "\n" : "");
  return ExitStatus::done;
}

struct CalibrateArguments {
  std::vector<std::string> compare;  // folders of two studies, in place of a study
  StudyOptions options;
  BatchArguments batch;
  std::string time_limit, memory_limit;
  std::vector<std::string> scope;  // of a record that is saved
  std::string database;
};

template <class Parse>
double parsed(const char* option, const std::string& text, Parse parse) {
  try {
    return text.empty() ? 0 : parse(text);
  } catch (const InputError& e) {
    throw InputError(fmt::format("{}: {}", option, e.what()));
  }
}

double positive_time(const std::string& text) {
  const double time = parse_quantity(text, dimension::time);
  if (!(time > 0)) throw InputError(fmt::format("\"{}\" is not above 0; expected a time", text));
  return time;
}

// Default author of a record: the name of the account.
std::string account_name() {
  const passwd* account = getpwuid(getuid());
  return account == nullptr ? std::string("unknown") : std::string(account->pw_name);
}

// "temperature=-10 to -5 C"
ScopeLimit parse_scope(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == text.npos || equals == 0 || equals + 1 == text.size())
    throw InputError(fmt::format(
        "--scope {}: is not a limit; expected NAME=TEXT, such as \"temperature=-10 to -5 C\"",
        text));
  return {text.substr(0, equals), text.substr(equals + 1)};
}

void require_printable(const char* option, const std::string& text) {
  if (const std::string found = encode::first_control(text); !found.empty())
    throw InputError(
        fmt::format("{}: has the character {}; expected printable text", option, found));
}

// Whether the record could be written, before hours of work. Nothing when none is wanted.
std::unique_ptr<MaterialDatabase> open_database(const CalibrateArguments& a,
                                                StudyOptions& options) {
  if (options.save.name.empty()) return nullptr;
  if (options.save.author.empty()) options.save.author = account_name();
  for (const std::string& text : a.scope) options.save.scope.push_back(parse_scope(text));
  for (const std::string& text : a.scope) require_printable("--scope", text);
  require_printable("--author", options.save.author);
  require_printable("--note", options.save.note);
  auto database = std::make_unique<MaterialDatabase>(material_database_file(a.database),
                                                     MaterialDatabase::Access::write);
  database->require_writable_name(options.save.name);
  return database;
}

void save(const MaterialRecord& record, MaterialDatabase& database) {
  const StoredRecord stored = database.add({record}).front();
  print_lines(stderr, "saved as material {} in {}\n", stored.record.reference(), database.file());
  if (record.provenance.program_commit.find("-dirty") != std::string::npos)
    print_lines(stderr,
                "firn: runs were made by a program built from uncommitted sources ({}): the record "
                "cannot be reproduced; commit, build and save again\n",
                record.provenance.program_commit);
}

// The answer and where the report is, one line each.
std::string conclusion(const StudyDocument& results, const std::string& page) {
  std::vector<page::Property> facts = study_estimate(results);
  if (!page.empty()) facts.push_back({"Report", page});
  std::string text;
  for (const page::Property& fact : facts)
    text += fmt::format("{:<13} {}\n", fact.name + ":", fact.value);
  return text;
}

int run_study(const CalibrateArguments& a) {
  if (!a.compare.empty()) return compare(a.compare, a.batch.json);
  if (a.options.study_file.empty())
    throw InputError(
        "STUDY.toml: is missing; expected a study file, or --compare with two folders");
  StudyOptions options = a.options;
  apply(a.batch, options);
  options.time_limit = parsed("--time-limit", a.time_limit, positive_time);
  options.memory_limit = parsed("--memory-limit", a.memory_limit, parse_memory);
  const std::unique_ptr<MaterialDatabase> database = open_database(a, options);
  const StudySummary summary = calibrate(options);
  if (summary.record) save(*summary.record, *database);
  draw_example(summary);
  const bool ended = summary.verdict != StudyVerdict::interrupted;
  const std::string page = ended ? write_folder_page(summary.directory) : "";
  if (a.batch.json) {
    print_lines(stdout, "{}\n", summary.json);
  } else {
    print_lines(stdout, "{}\n{}\n{}", summary.table, summary.headline,
                ended ? conclusion(summary.document, page) : "");
    print_lines(stderr, "Everything about this study is in {}\n", summary.directory);
  }
  if (!summary.not_saved.empty()) {
    print_lines(stderr, "firn: {}\n", summary.not_saved);
    return ExitStatus::failed;
  }
  return summary.exit_status();
}

// How the answer is kept as a material record.
void add_save_options(CLI::App& command, CalibrateArguments& a) {
  StudyOptions& options = a.options;
  CLI::Option* save = command
                          .add_option("--save", options.save.name,
                                      "Keep the answer as the next version of this material record")
                          ->type_name("NAME");
  command
      .add_option("--author", options.save.author,
                  "Author that the record names; your account by default")
      ->needs(save)
      ->type_name("TEXT");
  command
      .add_option("--scope", a.scope,
                  "Condition for which the record is valid, such as\n"
                  "\"temperature=-10 to -5 C\" (may be repeated); none by default")
      ->needs(save)
      ->allow_extra_args(false)
      ->type_name("NAME=TEXT");
  command
      .add_option("--note", options.save.note,
                  "Text that the record keeps for its readers, such as where the\n"
                  "measurements are from; none by default")
      ->needs(save)
      ->type_name("TEXT");
  command.add_option("--database", a.database, database_help)->needs(save)->type_name("FILE");
}

}  // namespace

void add_calibrate_command(CLI::App& app, int& status) {
  auto a = std::make_shared<CalibrateArguments>();
  CLI::App* command = app.add_subcommand("calibrate", "Fit parameters of a case to measurements");
  command
      ->add_option("STUDY.toml", a->options.study_file,
                   "The study: case, parameters, targets, budget")
      ->type_name("");
  add_batch_options(*command, a->batch, "study");
  command
      ->add_option("--compare", a->compare,
                   "In place of a study: the folders of two finished ones, side by side")
      ->expected(2)
      ->type_name("DIR_A DIR_B");
  command->add_flag("--allow-programs", a->options.allow_programs,
                    "Start the programs that the study names as experiments: they run with your "
                    "rights, so only for studies that you trust");
  command
      ->add_option("--time-limit", a->time_limit,
                   "Wall time of one run, e.g. \"10 min\"; by default that of the study")
      ->type_name("TIME");
  command
      ->add_option("--memory-limit", a->memory_limit,
                   "Main memory of one run, e.g. \"2 GiB\"; by default that of the study")
      ->type_name("SIZE");
  add_save_options(*command, *a);
  command->callback([a, &status] { status = run_study(*a); });
}

void add_slurm_task_command(CLI::App& app, int& status) {
  auto list = std::make_shared<std::string>();
  auto index = std::make_shared<int>(0);
  CLI::App* command = app.add_subcommand("slurm-task",
                                         "One run of a study on a node of a cluster; "
                                         "firn calibrate --executor slurm calls it");
  command->group("");  // nothing that people would type
  command->add_option("LIST", *list, "File with the list of runs of the study")
      ->required()
      ->type_name("");
  command->add_option("INDEX", *index, "Position of the run in the list")
      ->required()
      ->type_name("");
  command->callback([list, index, &status] {
    status = run_slurm_task(*list, *index, &interruption::requested());
  });
}

}  // namespace firn
