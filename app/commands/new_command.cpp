// firn new: a folder with a case, a study or a validation that runs, to start from.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <memory>
#include <sstream>

#include "app/commands/commands.h"
#include "app/output/response_output.h"
#include "app/support/embedded_templates.h"
#include "app/support/exit_status.h"
#include "app/support/known_words.h"
#include "app/support/shared_options.h"
#include "experiments/system/output_file.h"
#include "experiments/system/terminal.h"
#include "experiments/system/text_encoding.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

struct NewArguments {
  std::string name, from;
  bool list = false, json = false;
};

// Template -> file -> text.
std::map<std::string, std::map<std::string, std::string_view>> templates() {
  std::map<std::string, std::map<std::string, std::string_view>> all;
  for (const auto& [path, text] : embedded_templates()) {
    const std::size_t slash = path.find('/');
    all[std::string(path.substr(0, slash))][std::string(path.substr(slash + 1))] = text;
  }
  return all;
}

// The first sentences of its README: what stands between the title and the first command.
std::string description_of(const std::map<std::string, std::string_view>& files) {
  const std::string_view readme = files.at("README.md");
  const std::size_t from = readme.find("\n\n") + 2;
  std::string text(readme.substr(from, readme.find("\n\n", from) - from));
  for (char& c : text)
    if (c == '\n') c = ' ';
  return text;
}

// How the user calls the program in any folder: `firn`, or the launcher of a checkout that is not
// on the PATH.
std::string program_word() {
  const char* launcher = std::getenv("FIRN_LAUNCHER");
  const char* path = std::getenv("PATH");
  if (launcher == nullptr) return "firn";
  std::istringstream folders(path == nullptr ? "" : path);
  std::error_code error;
  for (std::string folder; std::getline(folders, folder, ':');)
    if (fs::is_regular_file(fs::path(folder) / "firn", error)) return "firn";
  return encode::shell_word(launcher);
}

// The commands of its README, one a line, as they can be typed.
std::string commands_of(const std::map<std::string, std::string_view>& files) {
  const std::string_view readme = files.at("README.md");
  const std::size_t from = readme.find("```\n") + 4;
  std::istringstream block(std::string(readme.substr(from, readme.find("```", from) - from)));
  std::string commands;
  for (std::string line; std::getline(block, line);)
    commands += line.starts_with("firn ") ? program_word() + line.substr(4) + "\n" : line + "\n";
  return commands;
}

int list_templates(const NewArguments& a) {
  if (a.json) {
    Json list = Json::array();
    for (const auto& [name, files] : templates())
      list.push_back({{"name", name}, {"description", description_of(files)}});
    print_json(list);
    return ExitStatus::done;
  }
  for (const auto& [name, files] : templates())
    print_lines(stdout, "{:<16}{}\n", name, description_of(files));
  return ExitStatus::done;
}

// Throws InputError when the folder cannot be the place of a new one.
void require_new_folder(const fs::path& folder) {
  std::error_code error;
  const fs::file_status status = fs::symlink_status(folder, error);
  if (!fs::exists(status)) return;
  if (!fs::is_directory(status) || !fs::is_empty(folder, error) || error)
    throw InputError(
        fmt::format("{}: exists; expected the name of a new or an empty folder", folder.string()));
}

int create(const NewArguments& a) {
  const auto all = templates();
  std::vector<std::string> names;
  for (const auto& [name, files] : all) names.push_back(name);
  const auto chosen = all.find(a.from);
  if (chosen == all.end())
    throw InputError(a.from.empty() ? fmt::format("--from: is missing; expected one of {}",
                                                  fmt::join(names, ", "))
                                    : fmt::format("--from: \"{}\" is not a template; {}", a.from,
                                                  expected_word(a.from, names)));
  if (a.name.empty()) throw InputError("NAME: is missing; expected the name of a new folder");
  const fs::path folder = a.name;
  require_new_folder(folder);
  make_output_folder(folder.string());
  for (const auto& [file, text] : chosen->second) write_file((folder / file).string(), text);
  if (a.json) {
    Json files = Json::array();
    for (const auto& [file, text] : chosen->second) files.push_back((folder / file).string());
    print_json({{"folder", folder.string()}, {"template", a.from}, {"files", files}});
    return ExitStatus::done;
  }
  print_lines(stdout, "{}\n", folder.string());
  print_lines(stderr,
              "firn: made {} from \"{}\"; README.md says what to edit first. Try:\ncd {}\n{}",
              folder.string(), a.from, folder.string(), commands_of(chosen->second));
  return ExitStatus::done;
}

}  // namespace

void add_new_command(CLI::App& app, int& status) {
  auto a = std::make_shared<NewArguments>();
  CLI::App* command = app.add_subcommand(
      "new", "Make a folder with a case, a study or a validation that runs, to start from");
  command->add_option("NAME", a->name, "Name of the folder to make, which must be new or empty")
      ->type_name("");
  command->add_option("--from", a->from, "Template of its files, one of the list below")
      ->type_name("TEMPLATE");
  command->add_flag("--list", a->list, "List the templates with what each is for");
  command->add_flag("--json", a->json, json_help);
  std::string footer = "Templates:\n";
  for (const auto& [name, files] : templates())
    footer += fmt::format("  {:<16}{}\n", name, description_of(files));
  command->footer(footer);
  command->callback([a, &status] { status = a->list ? list_templates(*a) : create(*a); });
}

}  // namespace firn
