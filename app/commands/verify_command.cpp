// firn verify: the verification suite, as a table and as a page.
#include <fmt/core.h>
#include <unistd.h>

#include <filesystem>
#include <memory>
#include <thread>

#include "app/commands/commands.h"
#include "app/output/response_output.h"
#include "app/support/exit_status.h"
#include "app/support/shared_options.h"
#include "experiments/storage/version.h"
#include "experiments/system/terminal.h"
#include "experiments/text/number_text.h"
#include "experiments/text/units.h"
#include "firn/contact_model.h"
#include "reports/documents/verification_page.h"
#include "validation/verification/suite.h"

namespace firn {
namespace {

using namespace verification;

struct VerifyArguments {
  std::vector<std::string> names;
  std::string page;
  int jobs = 0;
  bool full = false;
  bool list = false;
  bool checks = false;
  bool json = false;
};

int list_cases(const VerifyArguments& a) {
  const std::vector<VerificationCase> cases = select(a.names, true);
  if (a.json) {
    Json document = Json::array();
    for (const VerificationCase& c : cases) {
      document.push_back({{"name", c.name},
                          {"title", c.title},
                          {"reference", c.reference},
                          {"tier", c.tier == Tier::full ? "full" : "quick"}});
    }
    print_json(document);
    return ExitStatus::done;
  }
  for (const VerificationCase& c : cases) {
    print_lines(stdout, "{:<32}{:<7}{}\n", c.name, c.tier == Tier::full ? "full" : "quick",
                c.title);
  }
  return ExitStatus::done;
}

const char* verdict(const CaseResult& r) {
  return !r.error.empty() ? "ERROR" : passed(r) ? "holds" : "FAILS";
}

void print_check(const Check& c) {
  const std::string unit = unit_suffix(c.unit);
  print_lines(
      stdout, "    {} {}: {}, {} {:.6g}{}", passed(c) ? "holds" : "FAILS", c.what,
      measured_value_text(c),
      c.bound == Bound::at_most || c.bound == Bound::at_least ? tolerance_text(c) : "expected",
      c.expected, unit);
  if (c.bound == Bound::relative || c.bound == Bound::absolute)
    print_lines(stdout, " ({}, {} of it used)", tolerance_text(c),
                used_text(tolerance_fraction(c)));
  print_lines(stdout, "\n");
}

void print_table(const std::vector<VerificationCase>& cases, const std::vector<CaseResult>& results,
                 bool every_check) {
  print_lines(stdout, "{:<32}{:>7}{:>10}{:>9}  {:<7}{}\n", "case", "checks", "used", "time", "",
              "compared");
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const CaseResult& r = results[i];
    print_lines(stdout, "{:<32}{:>7}{:>9.2g}%{:>8.1f}s  {:<7}{}\n", cases[i].name, r.checks.size(),
                100 * max_tolerance_fraction(r), r.seconds, verdict(r), cases[i].title);
    if (!r.error.empty()) print_lines(stdout, "    {}\n", r.error);
    for (const Check& c : r.checks) {
      if (every_check || !passed(c)) print_check(c);
    }
  }
}

Json results_json(const std::vector<VerificationCase>& cases,
                  const std::vector<CaseResult>& results) {
  Json document = {{"firn_version", firn_version()},
                   {"git_commit", firn_git_commit()},
                   {"contact_model", kContactModel}};
  Json list = Json::array();
  bool all = true;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const CaseResult& r = results[i];
    Json checks = Json::array();
    for (const Check& c : r.checks) {
      const bool one_sided = c.bound == Bound::at_most || c.bound == Bound::at_least;
      checks.push_back({{"what", c.what},
                        {"unit", c.unit},
                        {"measured", c.measured},
                        {"expected", c.expected},
                        {"bound", c.bound == Bound::relative   ? "relative"
                                  : c.bound == Bound::absolute ? "absolute"
                                  : c.bound == Bound::at_most  ? "at_most"
                                                               : "at_least"},
                        {"tolerance", one_sided ? Json(nullptr) : Json(c.tolerance)},
                        {"passed", passed(c)}});
    }
    list.push_back({{"name", cases[i].name},
                    {"title", cases[i].title},
                    {"reference", cases[i].reference},
                    {"remark", cases[i].remark},
                    {"passed", passed(r)},
                    {"error", r.error.empty() ? Json(nullptr) : Json(r.error)},
                    {"seconds", r.seconds},
                    {"checks", checks}});
    all = all && passed(r);
  }
  document["passed"] = all;
  document["cases"] = list;
  return document;
}

int verify(const VerifyArguments& a) {
  if (a.list) return list_cases(a);
  const std::vector<VerificationCase> cases = select(a.names, a.full);
  const int jobs =
      a.jobs > 0 ? a.jobs : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const std::string program = fmt::format("firn {} (commit {}, contact model {})", firn_version(),
                                          firn_git_commit(), kContactModel);
  const bool terminal = ::isatty(STDERR_FILENO) != 0;
  if (!a.page.empty())  // reports a wrong name before hours of work
    write_verification_page(cases, std::vector<CaseResult>(cases.size()), program, a.page);
  std::size_t ended = 0;
  const auto report = [&](std::size_t k, const std::vector<CaseResult>& so_far) {
    ++ended;
    // What is finished is on the page, whatever happens to the rest.
    if (!a.page.empty()) write_verification_page(cases, so_far, program, a.page);
    const std::string line = fmt::format("[{}/{}] {} {} ({})", ended, cases.size(), cases[k].name,
                                         verdict(so_far[k]), duration_text(so_far[k].seconds));
    if (terminal)
      print(stderr, fmt::format("\r\033[K{}{}", fit_columns(line, terminal_columns()),
                                ended < cases.size() ? "" : "\n"));
    else
      print(stderr, line + "\n");
    std::fflush(stderr);
  };
  const std::vector<CaseResult> results = run_cases(cases, jobs, report);
  if (a.json) {
    print_json(results_json(cases, results));
  } else {
    print_table(cases, results, a.checks);
  }
  std::size_t held = 0;
  for (const CaseResult& r : results) held += passed(r) ? 1 : 0;
  print_lines(stderr, "{} of {} cases hold\n", held, cases.size());
  if (!a.page.empty()) print_lines(stderr, "page: {}\n", a.page);
  return held == cases.size() ? ExitStatus::done : ExitStatus::requirement_missed;
}

}  // namespace

void add_verify_command(CLI::App& app, int& status) {
  auto arguments = std::make_shared<VerifyArguments>();
  CLI::App* command =
      app.add_subcommand("verify", "Compare the solver with closed forms and references");
  command
      ->add_option("NAME", arguments->names,
                   "Groups or cases to run, as --list names them; all by default")
      ->type_name("");
  command->add_flag("--full", arguments->full, "Also run the cases that take minutes");
  command->add_flag("--list", arguments->list, "List the cases without running them");
  command->add_flag("--checks", arguments->checks,
                    "Print every check, not those alone that are missed");
  command->add_option("-o", arguments->page, "Page to write, FILE.html or FILE.md; none by default")
      ->type_name("PAGE");
  command
      ->add_option("--jobs", arguments->jobs,
                   "Cases that run at the same time; one per core by default")
      ->type_name("N")
      ->check(CLI::PositiveNumber);
  command->add_flag("--json", arguments->json, json_help);
  command->callback([arguments, &status] { status = verify(*arguments); });
}

}  // namespace firn
