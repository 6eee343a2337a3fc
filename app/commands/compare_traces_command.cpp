// firn compare-traces: the first step at which two traces of runs differ.
#include <fmt/core.h>

#include <memory>

#include "app/commands/commands.h"
#include "app/output/response_output.h"
#include "app/support/exit_status.h"
#include "app/support/shared_options.h"
#include "experiments/inspection/state_trace.h"
#include "experiments/system/terminal.h"
#include "experiments/text/units.h"

namespace firn {
namespace {

struct CompareTracesArguments {
  std::string first, second;
  std::size_t listed = 10;
  bool json = false;
};

Json difference_json(const CompareTracesArguments& a, const TraceDifference& d) {
  Json document = {{"first", a.first},
                   {"second", a.second},
                   {"equal", d.equal},
                   {"same_case", d.same_case},
                   {"steps_compared", d.steps_compared},
                   {"only_in_first", d.only_first},
                   {"only_in_second", d.only_second},
                   {"last_equal_step", d.any_equal ? Json(d.last_equal) : Json()}};
  if (!d.equal) {
    document["first_difference"] = {
        {"step", d.step},
        {"time", d.time},
        {"groups", d.groups},
        {"numbers", d.has_numbers ? Json(d.numbers) : Json()},
        {"number_count", d.has_numbers ? Json(d.number_count) : Json()}};
  }
  return document;
}

void print_difference(const CompareTracesArguments& a, const TraceDifference& d) {
  if (!d.same_case) print_lines(stdout, "the traces are of different cases\n");
  if (d.equal) {
    print_lines(stdout, "equal: {} steps, the last one {}\n", d.steps_compared, d.last_equal);
  } else {
    print_lines(stdout, "first difference at step {} ({:.9g} s), in {}\n", d.step, d.time,
                comma_list(d.groups));
    if (d.any_equal)
      print_lines(stdout, "equal up to step {} ({} steps compared)\n", d.last_equal,
                  d.steps_compared - 1);
    if (d.any_equal && d.last_equal + 1 < d.step)
      print_lines(stdout, "steps {} ... {} are in neither trace or in one alone\n",
                  d.last_equal + 1, d.step - 1);
    for (const std::string& sentence : d.numbers) print_lines(stdout, "  {}\n", sentence);
    if (d.number_count > d.numbers.size())
      print_lines(stdout, "  and {} more numbers\n", d.number_count - d.numbers.size());
    if (d.has_numbers && d.number_count == 0)
      print_lines(
          stdout,
          "  no body, patch or point differs: the difference is in other parts of the state\n");
    if (!d.has_numbers)
      print_lines(stdout, "which numbers: run both again with --trace-numbers {}\n", d.step);
  }
  if (d.equal && d.only_first + d.only_second > 0)
    print_lines(stdout, "not compared: {} steps only in {}, {} only in {}\n", d.only_first, a.first,
                d.only_second, a.second);
}

int compare(const CompareTracesArguments& a) {
  const TraceDifference d = compare_traces(a.first, a.second, a.listed);
  if (a.json)
    print_json(difference_json(a, d));
  else
    print_difference(a, d);
  return d.equal ? ExitStatus::done : ExitStatus::failed;
}

}  // namespace

void add_compare_traces_command(CLI::App& app, int& status) {
  auto a = std::make_shared<CompareTracesArguments>();
  CLI::App* command =
      app.add_subcommand("compare-traces", "Find the first step at which two traced runs differ");
  command->add_option("FIRST", a->first, "Trace file of `firn run --trace-hashes`")
      ->required()
      ->type_name("");
  command->add_option("SECOND", a->second, "Trace file of another run of the same case")
      ->required()
      ->type_name("");
  command->add_option("--limit", a->listed, "List at most so many numbers of the state that differ")
      ->check(CLI::Range(0, 1000000000))
      ->type_name("N")
      ->capture_default_str();
  command->add_flag("--json", a->json, json_help);
  command->footer("Leaves with status 0 when they are equal, 1 when they differ.");
  command->callback([a, &status] { status = compare(*a); });
}

}  // namespace firn
