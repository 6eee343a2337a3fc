// firn: the command line. Parses, dispatches to a sub-command, and turns errors into one line on
// standard error and an exit status.
#include <fmt/core.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <exception>
#include <filesystem>
#include <mutex>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#include "app/batch_commands/commands.h"
#include "app/commands/commands.h"
#include "app/support/exit_status.h"
#include "app/support/known_words.h"
#include "app/support/renamed_arguments.h"
#include "experiments/results/results_guard.h"
#include "experiments/storage/hdf5_file.h"
#include "experiments/storage/version.h"
#include "experiments/system/interruption.h"
#include "experiments/system/output_file.h"
#include "experiments/system/terminal.h"
#include "experiments/text/alias.h"
#include "firn/contact_model.h"
#include "firn/math.h"

namespace firn {
namespace {

// Lines on standard error, without control sequences; those could come from any name.
class TerminalSink : public spdlog::sinks::base_sink<std::mutex> {
 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    print_lines(stderr, "{}\n", std::string_view(message.payload.data(), message.payload.size()));
  }
  void flush_() override { std::fflush(stderr); }
};

// Progress and log lines go to standard error. Standard output is for results.
void set_up_logging() {
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("firn", std::make_shared<TerminalSink>()));
}

// The text of an error as one line of limited length.
std::string error_line(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  text = one_line(std::move(text));
  constexpr std::size_t kMost = 4000;  // what a file quotes can be of any length
  if (text.size() > kMost) text = text.substr(0, kMost) + " ...";
  return text;
}

int print_error(const std::string& text, int status) {
  interruption::wait_for_end();
  print_lines(stderr, "firn: {}\n", error_line(text));
  return status;
}

void warn_of_old_argument(const RenamedArgument& renamed) {
  print_lines(stderr, "firn: warning: {}\n", old_name_warning(renamed.old_name, renamed.name));
}

std::string command_of(const CLI::App& app) {
  const auto chosen = app.get_subcommands();
  return chosen.empty() ? "firn" : chosen[0]->get_name();
}

// Help and version are no errors; everything else is a mistake in the arguments.
int finish_parsing(const CLI::App& app, const CLI::ParseError& e,
                   const std::vector<std::string>& arguments) {
  if (e.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) return app.exit(e);
  if (arguments.empty()) {
    print_lines(stderr, "{}", app.help());
    return ExitStatus::bad_input;
  }
  // Before what CLI11 reports: a misspelled option is missing in its place, too.
  if (const std::string unknown = unknown_argument(app); !unknown.empty())
    return print_error(unknown, ExitStatus::bad_input);
  // The message about a refused value states which values the option takes.
  if (dynamic_cast<const CLI::ValidationError*>(&e) != nullptr)
    return print_error(e.what(), ExitStatus::bad_input);
  const auto chosen = app.get_subcommands();
  return print_error(fmt::format("{}; see `firn {}--help`", error_line(e.what()),
                                 chosen.empty() ? "" : chosen[0]->get_name() + " "),
                     ExitStatus::bad_input);
}

void add_program_options(CLI::App& app) {
  app.set_version_flag("--version",
                       fmt::format("firn {} ({}), contact model {}", firn_version(),
                                   firn_git_commit(), kContactModel),
                       "Print the version, the commit it was built from and the contact model");
  app.set_help_flag("-h,--help", "Print this help");
  app.require_subcommand(1);
  app.get_formatter()->column_width(34);
  app.footer(
      "Exit status: 0 done, 1 the run failed, 2 bad input or usage, 3 a --require bound was "
      "missed,\n"
      "130 interrupted; what was finished or saved is kept. Results go to standard output, the "
      "rest to standard\n"
      "error. `firn COMMAND --help` explains one command.");
}

// In the order of the help text.
void add_commands(CLI::App& app, int& status) {
  add_new_command(app, status);
  add_run_command(app, status);
  add_measure_command(app, status);
  add_calibrate_command(app, status);
  add_slurm_task_command(app, status);
  add_shape_command(app, status);
  add_export_command(app, status);
  add_view_command(app, status);
  add_sweep_command(app, status);
  add_optimize_command(app, status);
  add_validate_command(app, status);
  add_report_command(app, status);
  add_verify_command(app, status);
  add_contacts_command(app, status);
  add_compare_traces_command(app, status);
  add_materials_command(app, status);
  add_check_results_command(app, status);
}

// Parses the arguments and carries out the command, which sets `status`. Errors become one line on
// standard error.
int parse_and_run(CLI::App& app, const std::vector<std::string>& arguments, const int& status) {
  try {
    app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
    return status;
  } catch (const CLI::ParseError& e) {
    return finish_parsing(app, e, arguments);
  } catch (const InputError& e) {
    return print_error(e.what(), ExitStatus::bad_input);
  } catch (const RunError& e) {
    return print_error(e.what(), ExitStatus::failed);
  } catch (const hdf5::Error& e) {
    return print_error(e.what(), ExitStatus::failed);
  } catch (const std::filesystem::filesystem_error& e) {
    return print_error(fmt::format("{}: {}", e.path1().string(), e.code().message()),
                       ExitStatus::failed);
  } catch (const std::bad_alloc&) {
    return print_error(
        fmt::format("{}: there is not enough memory; expected smaller input or a larger machine",
                    command_of(app)),
        ExitStatus::failed);
  } catch (const std::exception& e) {
    return print_error(
        fmt::format("{}: an error that should not occur ({}); please report it with the input "
                    "files",
                    command_of(app), e.what()),
        ExitStatus::failed);
  }
}

int main_program(int argc, char** argv) {
  set_up_logging();
  int status = ExitStatus::done;
  CLI::App app{
      "Simulates ice cubes in icemakers with the discrete element method, and fits the parameters "
      "of\n"
      "their contacts to measurements.",
      "firn"};
  add_program_options(app);
  add_commands(app, status);
  guard_results_with("/proc/self/exe");  // also after an update has replaced its file
  const std::vector<std::string> arguments = current_arguments(
      std::vector<std::string>(argv + std::min(argc, 1), argv + argc), warn_of_old_argument);
  status = parse_and_run(app, arguments, status);
  interruption::wait_for_end();
  try {
    finish_standard_output();
  } catch (const WriteError& e) {
    const bool good = status == ExitStatus::done || status == ExitStatus::requirement_missed;
    return print_error(e.what(), good ? ExitStatus::failed : status);
  }
  return status;
}

}  // namespace
}  // namespace firn

int main(int argc, char** argv) {
  // A file that reaches the limit of its size is an error of the write, not a sudden death.
  std::signal(SIGXFSZ, SIG_IGN);
  // So is a reader that has gone.
  std::signal(SIGPIPE, SIG_IGN);
  firn::interruption::install();
  firn::occupy_standard_streams();
  return firn::main_program(argc, argv);
}
