#include "calibrate/study/user_program.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "experiments/batch/execution/program_process.h"
#include "experiments/storage/sha256.h"
#include "experiments/system/input_file.h"
#include "experiments/system/input_limits.h"
#include "experiments/system/output_file.h"
#include "experiments/text/toml_document.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t most_template_bytes = 16 * input_limits::kMiB;
constexpr std::size_t most_arguments = 1000, most_inputs = 1000;

// Calls `found(name, line)` for each {{name}} and puts what it returns in its place. Braces that
// enclose no name on one line are text.
std::string replace_placeholders(
    const std::string& text,
    const std::function<std::string(const std::string& name, std::size_t line)>& found) {
  std::string result;
  std::size_t at = 0, line = 1;
  for (std::size_t open; (open = text.find("{{", at)) != text.npos;) {
    const std::size_t end = text.find_first_of("{}\n", open + 2);
    const bool closed = end != text.npos && text.compare(end, 2, "}}") == 0;
    const std::size_t next = closed ? end + 2 : open + 2;
    const std::string name = closed ? trimmed(text.substr(open + 2, end - open - 2)) : "";
    line += static_cast<std::size_t>(std::count(text.begin() + static_cast<std::ptrdiff_t>(at),
                                                text.begin() + static_cast<std::ptrdiff_t>(open),
                                                '\n'));
    result += text.substr(at, open - at);
    result += name.empty() ? text.substr(open, next - open) : found(name, line);
    at = next;
  }
  return result + text.substr(at);
}

bool is_below(const fs::path& path) {
  return path.is_relative() && !path.empty() && *path.begin() != "..";
}

// The name of a file of the study in the folder of a run: its own path, unless that leads out of
// the study's folder.
std::string name_in_run(const std::string& path) {
  const fs::path normal = fs::path(path).lexically_normal();
  return is_below(normal) ? normal.string() : normal.filename().string();
}

std::string path_from_study(const std::string& study_file, const std::string& path) {
  return (fs::path(study_file).parent_path() / path).lexically_normal().string();
}

bool can_start(const std::string& file) {
  std::error_code unreadable;
  return fs::is_regular_file(file, unreadable) && access(file.c_str(), X_OK) == 0;
}

bool in_search_path(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "/usr/bin:/bin" : path);
  for (std::string folder; std::getline(folders, folder, ':');)
    if (can_start((fs::path(folder) / name).string())) return true;
  return false;
}

void require_program(const TomlTable& t, const UserProgram& p) {
  const std::string& name = p.arguments.front();
  const auto input = std::find_if(p.inputs.begin(), p.inputs.end(), [&](const ProgramInput& i) {
    return i.name == fs::path(name).lexically_normal();
  });
  const bool with_path = name.find('/') != name.npos;
  const bool found = with_path && input != p.inputs.end() ? can_start(input->file)
                     : with_path ? fs::path(name).is_absolute() && can_start(name)
                                 : in_search_path(name);
  if (!found)
    t.fail("program",
           fmt::format(
               "\"{}\" is not a program that can be started; expected the name of one in PATH, "
               "an absolute path, or \"./NAME\" of an executable file in the folder of the study",
               name));
}

void add_input(const TomlTable& t, const char* key, const std::string& study_file,
               const std::string& path, UserProgram& p) {
  ProgramInput input{name_in_run(path), path_from_study(study_file, path), {}};
  for (const ProgramInput& other : p.inputs)
    if (other.name == input.name) {
      if (other.file == input.file) return;
      t.fail(key, fmt::format("{} and {} would have the same name in the folder of a run; expected "
                              "different names",
                              other.file, input.file));
    }
  if (input.name == p.template_name || input.name == p.responses)
    t.fail(key,
           fmt::format("\"{}\" is the template or the file of responses, too; expected another "
                       "name",
                       path));
  if (p.inputs.size() == most_inputs)
    t.fail(key, fmt::format("names more than {} files; expected fewer", most_inputs));
  input.hash = sha256(t.at(key, [&] {
    return read_input_file(input.file, "an input file of the program",
                           input_limits::raw_data_bytes);
  }));
  p.inputs.push_back(input);
}

void read_template(const TomlTable& t, const std::string& study_file, UserProgram& p) {
  if (!t.has("template")) return;
  p.template_name = name_in_run(t.string("template"));
  p.template_text = t.at("template", [&] {
    return read_input_file(path_from_study(study_file, t.string("template")),
                           "a text with {{placeholders}}", most_template_bytes);
  });
  try {
    nlohmann::json(p.template_text).dump();
  } catch (const nlohmann::json::exception&) {
    t.fail("template", "is no UTF-8 text; expected one (binary files go to `inputs`)");
  }
}

std::string read_responses_name(const TomlTable& t) {
  const std::string name = t.string("responses");
  const fs::path path(name);
  if (path.has_parent_path() || name.starts_with('-') ||
      (path.extension() != ".json" && path.extension() != ".csv"))
    t.fail("responses", fmt::format("\"{}\" is not the name of a file of responses; expected the "
                                    "name of the .json or .csv file that "
                                    "the program writes into its working folder",
                                    name));
  return name;
}

}  // namespace

UserProgram read_user_program(const TomlTable& t, const std::string& study_file,
                              Programs programs) {
  if (programs == Programs::refused)
    t.fail("program",
           "the study starts a program; expected the option --allow-programs, from a user who "
           "trusts the study and its files");
  for (const char* key : {"case"})
    if (t.has(key)) t.fail(key, "is given together with program; expected one or the other");
  UserProgram p;
  p.arguments = t.strings("program");
  if (p.arguments.empty() || p.arguments.front().empty() || p.arguments.size() > most_arguments)
    t.fail("program",
           "is no list of a program and its arguments; expected one such as [\"python3\", "
           "\"simulate.py\"]");
  p.responses = read_responses_name(t);
  read_template(t, study_file, p);
  if (p.template_name == p.responses)
    t.fail("template", "has the name of the responses; expected another name");
  for (const std::string& path : t.strings("inputs")) add_input(t, "inputs", study_file, path, p);
  // A file that an argument names counts by content, as if it were listed.
  for (const std::string& argument : p.arguments) {
    std::error_code unreadable;
    const fs::path path(argument);
    if (is_below(path.lexically_normal()) && name_in_run(argument) != p.template_name &&
        (argument != p.arguments.front() || argument.find('/') != argument.npos) &&
        fs::is_regular_file(path_from_study(study_file, argument), unreadable))
      add_input(t, "program", study_file, argument, p);
  }
  require_program(t, p);
  return p;
}

void require_placeholders(const TomlTable& t, const UserProgram& p,
                          const std::vector<std::string>& names) {
  std::set<std::string> used;
  const auto scan = [&](const char* key, const std::string& text, const std::string& where) {
    replace_placeholders(text, [&](const std::string& name, std::size_t line) {
      if (name != "seed" && std::find(names.begin(), names.end(), name) == names.end())
        t.fail(key, fmt::format(
                        "{}{{{{{}}}}} is neither a parameter that the experiment takes nor a key "
                        "of its `set`; expected one of those, or seed",
                        where.empty() ? "" : fmt::format("{}:{}: ", where, line), name));
      used.insert(name);
      return std::string();
    });
  };
  for (const std::string& argument : p.arguments) scan("program", argument, "");
  scan("template", p.template_text, p.template_name);
  for (const std::string& name : names)
    if (!used.contains(name))
      t.fail(p.template_name.empty() ? "program" : "template",
             fmt::format("{{{{{}}}}} occurs neither in the template nor in the arguments; expected "
                         "a place for its value",
                         name));
}

ProgramRun program_run(const UserProgram& p, const std::map<std::string, std::string>& values) {
  const auto fill = [&](const std::string& text) {
    return replace_placeholders(
        text, [&](const std::string& name, std::size_t) { return values.at(name); });
  };
  ProgramRun run;
  for (const std::string& argument : p.arguments) run.arguments.push_back(fill(argument));
  run.input_name = p.template_name;
  run.input_text = fill(p.template_text);
  for (const ProgramInput& input : p.inputs) run.inputs[input.name] = input.hash;
  run.responses = p.responses;
  run.values = values;
  return run;
}

std::string placeholder_text(const std::string& toml_value) {
  if (!toml_value.starts_with('"') && !toml_value.starts_with('\'')) return toml_value;
  TomlDocument document("text = " + toml_value, "set");
  return TomlTable::root(document).string("text");
}

void keep_inputs(const UserProgram& p, const std::string& runs_folder) {
  for (const ProgramInput& input : p.inputs) {
    const std::string kept = program_input_file(runs_folder, input.hash);
    std::error_code error;
    if (fs::exists(kept, error)) continue;
    const std::string content =
        read_input_file(input.file, "an input file of the program", input_limits::raw_data_bytes);
    if (sha256(content) != input.hash)
      throw InputError(
          fmt::format("{}: has changed since the study was read; start again", input.file));
    make_output_folder(fs::path(kept).parent_path().string());
    const fs::perms mode = fs::status(input.file).permissions();
    write_own_file(kept, content);
    constexpr fs::perms writers =
        fs::perms::owner_write | fs::perms::group_write | fs::perms::others_write;
    fs::permissions(kept, mode & ~writers, error);  // runs share the file
  }
}

}  // namespace firn
