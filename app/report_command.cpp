// firn report: a page for people from what has been computed.
#include <fmt/core.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/commands.h"
#include "app/exit_status.h"
#include "reports/validation_page.h"
#include "solver/types.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::string path, output;
  bool json = false;
};

int make_report(const Arguments& a) {
  fs::path source = a.path;
  if (fs::is_directory(source)) source /= "results.json";
  if (!fs::exists(source))
    throw InputError(
        fmt::format("{}: does not exist; expected the folder of a validation, or its results.json",
                    source.string()));
  const page::Page page = validation_page(source.string());
  const std::string output =
      a.output.empty() ? (source.parent_path() / "report.html").string() : a.output;
  page.write(output);
  if (a.json)
    fmt::print("{}\n", nlohmann::json{{"report", output}}.dump());
  else
    fmt::print("{}\n", output);
  return ExitStatus::done;
}

}  // namespace

void add_report_command(CLI::App& app, int& status) {
  auto a = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "report", "One HTML page that stands alone, from the results of a validation");
  command->add_option("PATH", a->path, "The folder of a validation")->required()->type_name("");
  command->add_option("-o,--output", a->output, "The page; report.html in the folder by default")
      ->type_name("REPORT.html");
  command->add_flag("--json", a->json, "Print JSON on standard output and nothing else");
  command->callback([a, &status] { status = make_report(*a); });
}

}  // namespace firn
