// firn report: a page for people from what has been computed.
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/commands.h"
#include "app/exit_status.h"
#include "experiments/terminal.h"
#include "reports/json_values.h"
#include "reports/run_page.h"
#include "reports/study_page.h"
#include "reports/validation_page.h"
#include "solver/types.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::string path, output, figures;
  bool json = false, no_replays = false;
};

// A results file, or what a study or a validation left; and where its page goes.
struct Report {
  page::Page page;
  fs::path output;
};

// Studies and validations leave files of one name.
bool is_study(const fs::path& results) {
  const Json json = read_results_json(results.string());
  return json.is_object() && json.contains("study");
}

Report report_of(const std::string& path, bool replays) {
  fs::path source = path;
  if (source.extension() == ".h5")
    return {run_page(path), fs::path(path).replace_extension(".html")};
  std::error_code unreadable;  // as a name that is too long
  if (fs::is_directory(source, unreadable)) source /= "results.json";
  if (!fs::exists(source, unreadable))
    throw InputError(
        fmt::format("{}: does not exist; expected RUN.h5, the folder of a study or a validation, "
                    "or its results.json",
                    source.string()));
  const bool study = is_study(source);
  return {
      study ? study_page(source.string()) : validation_page(source.string(), {.replays = replays}),
      source.parent_path() / "report.html"};
}

int make_report(const Arguments& a) {
  const Report report = report_of(a.path, !a.no_replays);
  const std::string output = a.output.empty() ? report.output.string() : a.output;
  report.page.write(output);
  std::vector<std::string> figures;
  if (!a.figures.empty()) figures = report.page.write_figures(a.figures);
  nlohmann::json done = {{"report", output}};
  if (!a.figures.empty()) done["figures"] = figures;
  if (a.json)
    print_lines(stdout, "{}\n",
                done.dump(-1, ' ', false, decltype(done)::error_handler_t::replace));
  else
    print_lines(stdout, "{}\n{}", output,
                figures.empty() ? "" : fmt::format("{}\n", fmt::join(figures, "\n")));
  return ExitStatus::done;
}

}  // namespace

void add_report_command(CLI::App& app, int& status) {
  auto a = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("report",
                                         "One HTML page that stands alone, from the results of a "
                                         "run (with a replay), a study or a validation");
  command
      ->add_option("PATH", a->path,
                   "Results file of firn run, or the folder of a study or a validation")
      ->required()
      ->type_name("");
  command
      ->add_option("-o,--output", a->output,
                   "The page; by default RUN.html, or report.html in the folder")
      ->type_name("PAGE.html");
  command
      ->add_option("--figures", a->figures, "Also write every plot as an SVG file into this folder")
      ->type_name("FOLDER");
  command->add_flag("--no-replays", a->no_replays,
                    "Leave the replays out of the page of a validation");
  command->add_flag("--json", a->json, "Print JSON on standard output and nothing else");
  command->callback([a, &status] { status = make_report(*a); });
}

}  // namespace firn
