// Completion in bash: the function of scripts/bash-completion, called as bash does.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "tests/app/command_line/help_text.h"
#include "tests/app/program.h"

namespace firn::cli {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::IsSupersetOf;
using testing::UnorderedElementsAre;
using testing::UnorderedElementsAreArray;

class Completion : public testing::Test {
 protected:
  // The words that bash offers in place of the last one.
  std::vector<std::string> offered(const std::vector<std::string>& words) const {
    const std::string script = "source '" FIRN_SOURCE_DIR
                               "/scripts/bash-completion'; COMP_WORDS=(\"$@\"); "
                               "COMP_CWORD=$(($# - 1)); _firn; [ ${#COMPREPLY[@]} = 0 ] || "
                               "printf '%s\\n' \"${COMPREPLY[@]}\"";
    std::vector<std::string> arguments = {"bash", "--norc", "-c", script, "bash", FIRN_PROGRAM};
    arguments.insert(arguments.end(), words.begin(), words.end());
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    const std::string out = (folder_.path() / ".completion").string();
    const pid_t pid = fork();
    if (pid == 0) {
      const bool ready = chdir(folder_.path().c_str()) == 0 &&
                         dup2(open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), 1) == 1;
      if (ready) execvp(argv[0], argv.data());
      _exit(127);
    }
    int status = 0;
    waitpid(pid, &status, 0);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    std::istringstream text(read_text(out));
    std::vector<std::string> found;
    for (std::string line; std::getline(text, line);) found.push_back(line);
    return found;
  }

  void SetUp() override {
    for (const char* name : {"a.toml", "b.h5", "c.stl", "d.txt", "two words.toml"})
      folder_.write(name, "");
    std::filesystem::create_directory(folder_.path() / "runs");
  }

  Folder folder_;
};

TEST_F(Completion, OfSubCommandsAndOptions) {
  for (const std::vector<std::string>& command : all_commands(folder_)) {
    SCOPED_TRACE(testing::PrintToString(command));
    const std::string help = help_of(folder_, command);
    std::vector<std::string> subs, options;
    for (const HelpEntry& entry : help_entries(help, "Subcommands")) subs.push_back(entry.name);
    for (const HelpEntry& entry : help_entries(help, "Options"))
      if (entry.name.starts_with("--")) options.push_back(entry.name);
    std::vector<std::string> words = command;
    words.emplace_back("");
    if (!subs.empty()) {
      EXPECT_THAT(offered(words), UnorderedElementsAreArray(subs));
    }
    words.back() = "--";
    EXPECT_THAT(offered(words), UnorderedElementsAreArray(options));
  }
  EXPECT_THAT(offered({"cal"}), ElementsAre("calibrate"));
  EXPECT_THAT(offered({"run", "--see"}), ElementsAre("--seed"));
}

// Every option with a fixed set of values, in both spellings, with a random beginning.
TEST_F(Completion, OfFixedValues) {
  std::mt19937_64 random(5);
  int options = 0;
  for (const std::vector<std::string>& command : all_commands(folder_))
    for (const HelpEntry& option : help_entries(help_of(folder_, command), "Options")) {
      const std::vector<std::string> values = values_of(option);
      if (values.empty()) continue;
      ++options;
      SCOPED_TRACE(testing::PrintToString(command) + option.name);
      std::vector<std::string> words = command;
      words.insert(words.end(), {option.name, ""});
      EXPECT_THAT(offered(words), UnorderedElementsAreArray(values));
      words.insert(words.end() - 1, "=");
      EXPECT_THAT(offered(words), UnorderedElementsAreArray(values));
      const std::string& one = values[random() % values.size()];
      words.back() = one.substr(0, 1 + random() % one.size());
      std::vector<std::string> expected = values;
      std::erase_if(expected, [&](const std::string& v) { return !v.starts_with(words.back()); });
      EXPECT_THAT(offered(words), UnorderedElementsAreArray(expected));
    }
  EXPECT_GE(options, 10);
  EXPECT_THAT(offered({"new", "x", "--from", ""}), IsSupersetOf({"bucket", "hopper", "repose"}));
  EXPECT_THAT(offered({"new", "x", "--from", "ho"}), ElementsAre("hopper"));
}

TEST_F(Completion, OfFilesByTheirKind) {
  const auto cases = UnorderedElementsAre("a.toml", "two words.toml", "runs");
  const auto results = UnorderedElementsAre("b.h5", "runs");
  const auto all = IsSupersetOf({"a.toml", "b.h5", "c.stl", "d.txt", "two words.toml", "runs"});
  for (const char* command : {"run", "calibrate", "sweep", "optimize", "validate"})
    EXPECT_THAT(offered({command, ""}), cases) << command;
  for (const char* command : {"measure", "export"})
    EXPECT_THAT(offered({command, ""}), results) << command;
  EXPECT_THAT(offered({"run", "--resume", ""}), results);
  EXPECT_THAT(offered({"run", "a.toml", "-o", ""}), results);
  EXPECT_THAT(offered({"run", "--seed", "3", ""}), cases);
  EXPECT_THAT(offered({"run", "--seed", "=", "3", ""}), cases);
  EXPECT_THAT(offered({"run", "two"}), ElementsAre("two words.toml"));
  EXPECT_THAT(offered({"contacts", ""}),
              UnorderedElementsAre("a.toml", "two words.toml", "b.h5", "runs"));
  EXPECT_THAT(offered({"shape", "a.stl", "--repair-to", ""}),
              UnorderedElementsAre("c.stl", "runs"));
  EXPECT_THAT(offered({"sweep", "a.toml", "-o", ""}), ElementsAre("runs"));
  EXPECT_THAT(offered({"sweep", "a.toml", "--output", "r"}), ElementsAre("runs"));
  EXPECT_THAT(offered({"sweep", "--cache", ""}), all);
  EXPECT_THAT(offered({"sweep", "--no-cache", ""}), cases);
  for (const char* command : {"report", "view"}) EXPECT_THAT(offered({command, ""}), all);
  // A number, a name or a time is no file.
  EXPECT_THAT(offered({"run", "--seed", ""}), IsEmpty());
  EXPECT_THAT(offered({"shape", "--density", ""}), IsEmpty());
  EXPECT_THAT(offered({"measure", "b.h5", "--require", ""}), IsEmpty());
}

// Wherever a command takes a record, with a random beginning.
TEST_F(Completion, OfMaterialRecords) {
  std::vector<std::string> names;
  for (const auto& record :
       nlohmann::json::parse(folder_.firn({"materials", "list", "--json"}).out))
    names.push_back(record["name"].get<std::string>());
  ASSERT_THAT(names, Contains("paper-table-1"));
  std::mt19937_64 random(8);
  for (std::vector<std::string> words :
       std::vector<std::vector<std::string>>{{"materials", "show"},
                                             {"materials", "history"},
                                             {"materials", "diff"},
                                             {"materials", "diff", "paper-text"},
                                             {"materials", "export", "paper-text"},
                                             {"materials", "verify", "--json"},
                                             {"run", "a.toml", "--material"},
                                             {"run", "--material", "="},
                                             {"view", "a.toml", "--material"},
                                             {"validate", "--material"}}) {
    SCOPED_TRACE(testing::PrintToString(words));
    words.emplace_back("");
    EXPECT_THAT(offered(words), UnorderedElementsAreArray(names));
    const std::string& one = names[random() % names.size()];
    words.back() = one.substr(0, 1 + random() % one.size());
    std::vector<std::string> expected = names;
    std::erase_if(expected, [&](const std::string& n) { return !n.starts_with(words.back()); });
    EXPECT_THAT(offered(words), UnorderedElementsAreArray(expected));
  }
  // Files and names of other kinds.
  EXPECT_THAT(offered({"materials", "add", "pap"}), IsEmpty());
  EXPECT_THAT(offered({"verify", "pap"}), IsEmpty());
  EXPECT_THAT(offered({"new", "pap"}), IsEmpty());
}

}  // namespace
}  // namespace firn::cli
