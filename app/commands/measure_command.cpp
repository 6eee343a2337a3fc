// firn measure: responses from a results file, without simulating.
#include <fmt/core.h>

#include <algorithm>
#include <memory>

#include "app/commands/commands.h"
#include "app/output/response_output.h"
#include "app/support/exit_status.h"
#include "experiments/results/results_file.h"
#include "experiments/system/terminal.h"
#include "firn/math.h"

namespace firn {
namespace {

struct Arguments {
  std::string file;
  std::vector<std::string> names;
  std::vector<std::string> requirements;
  bool json = false;
};

std::vector<Response> chosen(const std::vector<Response>& all,
                             const std::vector<std::string>& names, const std::string& file) {
  if (names.empty()) return all;
  std::vector<Response> some;
  for (const std::string& name : names) {
    const auto found =
        std::find_if(all.begin(), all.end(), [&](const Response& r) { return r.name == name; });
    if (found == all.end()) {
      std::string known;
      for (const Response& r : all) known += (known.empty() ? "" : ", ") + r.name;
      throw InputError(fmt::format("{}: {}: no such response; expected one of: {}", file, name,
                                   known.empty() ? "none, the case has no responses" : known));
    }
    some.push_back(*found);
  }
  return some;
}

int measure_file(const Arguments& a) {
  std::vector<Requirement> requirements;
  for (const std::string& text : a.requirements) requirements.push_back(parse_requirement(text));
  const Recording recording(a.file);
  const std::vector<Response> all = measure(recording);
  const std::vector<Response> responses = chosen(all, a.names, a.file);
  const std::vector<Verdict> verdicts = judge(requirements, all);
  if (a.json) {
    Json document = {{"results_file", a.file},
                     {"status", recording.status()},
                     {"responses", responses_json(responses)}};
    if (!verdicts.empty()) document["requirements"] = verdicts_json(verdicts);
    print_json(document);
  } else {
    if (recording.status() != "finished") {
      print_lines(stderr, "{}: status of the run: {}\n", a.file, recording.status());
    }
    print_lines(stdout, "{}{}", responses_table(responses), verdicts_table(verdicts));
    if (responses.empty()) print_lines(stderr, "{}: the case has no responses\n", a.file);
  }
  return all_met(verdicts) ? ExitStatus::done : ExitStatus::requirement_missed;
}

}  // namespace

void add_measure_command(CLI::App& app, int& status) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      app.add_subcommand("measure", "Measure the responses of a results file again");
  command->add_option("RUN.h5", arguments->file, "Results file of `firn run`")
      ->required()
      ->type_name("");
  command->add_option("--response", arguments->names, "Only this response (may be repeated)")
      ->type_name("NAME")
      ->allow_extra_args(false);
  command->add_option("--require", arguments->requirements, requirement_help)
      ->type_name("\"RESPONSE<=VALUE\"")
      ->allow_extra_args(false);
  command->add_flag("--json", arguments->json, "Print JSON on standard output and nothing else");
  command->callback([arguments, &status] { status = measure_file(*arguments); });
}

}  // namespace firn
