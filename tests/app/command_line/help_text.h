// What the help texts of the program list.
#pragma once

#include <cstddef>
#include <sstream>
#include <string>
#include <vector>

#include "tests/app/program.h"

namespace firn::cli {

struct HelpEntry {
  std::string name;  // "--jobs", "STUDY.toml", "sweep"
  std::string type;  // of a value: "N", "TEXT:{local,slurm}=local"; empty: a flag
  std::string text;  // what the help says
};

// The entries below "Options:", "Positionals:" or "Subcommands:". Texts begin at a fixed column.
inline std::vector<HelpEntry> help_entries(const std::string& help, const std::string& section) {
  constexpr std::size_t kColumn = 34;
  std::vector<HelpEntry> entries;
  const std::size_t from = help.find("\n" + section + ":\n");
  if (from == std::string::npos) return entries;
  std::istringstream lines(help.substr(from + section.size() + 3));
  for (std::string line; std::getline(lines, line) && !line.empty();) {
    if (line.size() > 2 && line.starts_with("  ") && line[2] != ' ') {
      std::istringstream head(line.substr(0, kColumn));
      if (line.size() > kColumn && line[kColumn - 1] != ' ') head.str(line);
      HelpEntry entry;
      head >> entry.name >> entry.type;
      entry.name.erase(0, entry.name.starts_with("--") ? 0 : entry.name.find(",--") + 1);
      if (entry.type.ends_with(':')) entry.type.clear();  // "Needs:"
      if (line.size() > kColumn && line[kColumn - 1] == ' ') entry.text = line.substr(kColumn);
      entries.push_back(entry);
    } else if (!entries.empty() && line.size() > kColumn) {
      entries.back().text += " " + line.substr(kColumn);
    }
  }
  return entries;
}

// The commands of the program as words, those with sub-commands together with these. The first one
// is the program itself.
inline std::vector<std::vector<std::string>> all_commands(const Folder& folder) {
  std::vector<std::vector<std::string>> commands = {{}};
  for (std::size_t i = 0; i < commands.size(); ++i) {
    std::vector<std::string> words = commands[i];
    words.emplace_back("--help");
    for (const HelpEntry& sub : help_entries(folder.firn(words).out, "Subcommands")) {
      words.back() = sub.name;
      commands.push_back(words);
    }
  }
  return commands;
}

inline std::string help_of(const Folder& folder, std::vector<std::string> command) {
  command.emplace_back("--help");
  return folder.firn(command).out;
}

// a, b and c of "TEXT:{a,b,c}=a"; empty: any value.
inline std::vector<std::string> values_of(const HelpEntry& option) {
  const std::size_t from = option.type.find('{'), to = option.type.find('}');
  std::vector<std::string> values;
  if (from == std::string::npos || to == std::string::npos) return values;
  std::istringstream list(option.type.substr(from + 1, to - from - 1));
  for (std::string value; std::getline(list, value, ',');) values.push_back(value);
  return values;
}

}  // namespace firn::cli
