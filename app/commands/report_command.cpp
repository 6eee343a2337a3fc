// firn report: a page for people from what has been computed.
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/commands/commands.h"
#include "app/support/exit_status.h"
#include "app/support/report_page.h"
#include "app/support/shared_options.h"
#include "experiments/system/terminal.h"
#include "reports/html/pdf_file.h"

namespace firn {
namespace {

struct ReportArguments {
  std::string path, output, figures;
  bool json = false, no_replays = false;
};

int make_report(const ReportArguments& a) {
  const page::Page page = report_page(a.path, {.replays = !a.no_replays});
  const std::string output = a.output.empty() ? default_report_file(a.path).string() : a.output;
  if (std::filesystem::path(output).extension() == ".pdf")
    write_pdf(page, output);
  else
    page.write(output);
  std::vector<std::string> figures;
  if (!a.figures.empty()) figures = page.write_figures(a.figures);
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
  auto a = std::make_shared<ReportArguments>();
  CLI::App* command =
      app.add_subcommand("report",
                         "Self-contained HTML report, from the results of a "
                         "run (with a replay), a study, validation, sweep or optimization");
  command
      ->add_option(
          "PATH", a->path,
          "Results file of firn run, or the folder of a study, validation, sweep or optimization")
      ->required()
      ->type_name("");
  command
      ->add_option(
          "-o,--output", a->output,
          "The page; by default RUN.html, or report.html in the folder.\nPAGE.pdf is printed "
          "by an installed Chromium")
      ->type_name("PAGE.html|PAGE.pdf");
  command
      ->add_option("--figures", a->figures, "Also write every plot as an SVG file into this folder")
      ->type_name("FOLDER");
  command->add_flag("--no-replays", a->no_replays,
                    "Leave the replays out of the page of a validation");
  command->add_flag("--json", a->json, json_help);
  command->callback([a, &status] { status = make_report(*a); });
}

}  // namespace firn
