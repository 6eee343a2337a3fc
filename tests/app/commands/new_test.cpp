// firn new: every template runs by the commands of its README.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>
#include <thread>

#include "experiments/system/input_file.h"
#include "tests/app/program.h"

namespace firn::cli {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

TEST(NewCommand, ListsItsTemplates) {
  const Folder folder;
  const Outcome o = folder.firn({"new", "--list", "--json"});
  ASSERT_EQ(o.status, 0) << o.err;
  std::vector<std::string> names;
  for (const auto& t : nlohmann::json::parse(o.out)) {
    names.push_back(t.at("name"));
    EXPECT_GT(t.at("description").get<std::string>().size(), 20u);
  }
  EXPECT_THAT(names,
              testing::ElementsAre("bucket", "drum", "hopper", "icemaker", "own-angle", "own-study",
                                   "own-validation", "repose", "user-simulator"));
  const std::string help = folder.firn({"new", "--help"}).out;
  for (const std::string& name : names) EXPECT_THAT(help, HasSubstr(name));
}

TEST(NewCommand, KeepsWhatIsThere) {
  const Folder folder;
  const auto refused = [&](const std::vector<std::string>& arguments, const std::string& text) {
    const Outcome o = folder.firn(arguments);
    EXPECT_EQ(o.status, 2) << text;
    EXPECT_EQ(lines(o.err), 1u) << o.err;
    EXPECT_THAT(o.err, HasSubstr(text));
  };
  fs::create_directory(folder.path() / "full");
  folder.write("full/mine.txt", "mine");
  folder.write("file", "mine");
  fs::create_symlink("nowhere", folder.path() / "link");
  refused({"new", "full", "--from", "hopper"}, "full: exists");
  refused({"new", "file", "--from", "hopper"}, "file: exists");
  refused({"new", "link", "--from", "hopper"}, "link: exists");
  refused({"new", "fresh", "--from", "bin"}, "\"bin\" is not a template; expected one of bucket");
  refused({"new", "fresh"}, "--from: is missing");
  refused({"new", "--from", "hopper"}, "NAME: is missing");
  EXPECT_FALSE(folder.contains("fresh"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path() / "full"), {}), 1);
  fs::create_directory(folder.path() / "empty");
  EXPECT_EQ(folder.firn({"new", "empty", "--from", "hopper"}).status, 0);
  EXPECT_EQ(folder.firn({"new", "deep/er", "--from", "hopper"}).status, 0);
  EXPECT_TRUE(folder.contains("deep/er/case.toml"));
}

// `firn` is no command where a checkout is used by its launcher alone.
TEST(NewCommand, PrintsCommandsThatCanBeTyped) {
  const Folder folder;
  const auto printed = [&](const char* name, const std::string& path) {
    return folder
        .wait(folder.start({"new", name, "--from", "hopper"},
                           [&] {
                             ::setenv("FIRN_LAUNCHER", "/my tools/firn", 1);
                             ::setenv("PATH", path.c_str(), 1);
                           }))
        .err;
  };
  EXPECT_THAT(printed("a", "/nowhere:/none"), HasSubstr("\n'/my tools/firn' run case.toml -o"));
  fs::create_directory(folder.path() / "bin");
  folder.write("bin/firn", "");
  EXPECT_THAT(printed("b", "/nowhere:" + (folder.path() / "bin").string()),
              HasSubstr("\nfirn run case.toml -o"));
}

// The commands of the first block of a README, as words.
std::vector<std::vector<std::string>> commands_of(const fs::path& readme) {
  const std::string text = read_text(readme);
  const std::size_t from = text.find("```\n") + 4;
  std::istringstream block(text.substr(from, text.find("```", from) - from));
  std::vector<std::vector<std::string>> commands;
  for (std::string line; std::getline(block, line);) {
    std::istringstream words(line);
    std::vector<std::string>& command = commands.emplace_back();
    for (std::string word; words >> word;) command.push_back(word);
  }
  return commands;
}

void runs_as_its_readme_says(const std::string& name) {
  const Folder folder;
  const Outcome made = folder.firn({"new", "project", "--from", name});
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_EQ(made.out, "project\n");
  const auto in_project = [&](const std::vector<std::string>& arguments) {
    return folder.start(arguments, [] {
      if (chdir("project") != 0) _exit(126);
    });
  };
  int seen = 0;
  for (const std::vector<std::string>& command : commands_of(folder.path() / "project/README.md")) {
    ASSERT_EQ(command.at(0), "firn");
    std::vector<std::string> arguments(command.begin() + 1, command.end());
    SCOPED_TRACE(testing::PrintToString(arguments));
    ++seen;
    if (arguments[0] == "view") {
      arguments.push_back("--no-open");
      const pid_t pid = in_project(arguments);
      const std::string out = (folder.path() / ".out").string();
      for (int i = 0; i < 1200 && !read_own_file(out).ends_with("\n"); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
      std::this_thread::sleep_for(std::chrono::seconds(1));  // the page of the case is made
      ::kill(pid, SIGINT);
      const Outcome o = folder.wait(pid);
      EXPECT_EQ(o.status, 0) << o.err;
      EXPECT_THAT(o.out, HasSubstr("http://127.0.0.1:"));
      EXPECT_EQ(lines(o.err), 1u) << o.err;  // no error of the case
      continue;
    }
    const Outcome o = folder.wait(in_project(arguments));
    EXPECT_EQ(o.status, 0) << o.err;
    if (arguments[0] == "run") {
      EXPECT_THAT(o.out, HasSubstr("present_count"));
    }
  }
  EXPECT_GE(seen, 2);
}

// A command of a tutorial, as words, and the lines that the page shows of its output.
struct TutorialStep {
  std::vector<std::string> command, output;
};

// The steps of docs/tutorials/NAME.md; without firn view. Commands are blocks without a language,
// and a block of the language "text" has output of the last command before it. Commands in blocks
// of the language "sh" need files of the user.
std::vector<TutorialStep> tutorial(const std::string& name) {
  std::vector<TutorialStep> steps;
  std::istringstream page(read_text(fs::path(FIRN_SOURCE_DIR) / "docs/tutorials" / (name + ".md")));
  std::string language;
  bool block = false, has_output = false;  // the last command, whether it is among `steps`
  for (std::string line; std::getline(page, line);) {
    if (line.starts_with("```")) {
      block = !block;
      language = line.substr(3);
      if (block && language != "text") has_output = false;
      continue;
    }
    if (!block) continue;
    if (language == "text" && has_output) steps.back().output.push_back(line);
    if (!language.empty() || !line.starts_with("./firn ")) continue;
    std::istringstream words(line);
    std::vector<std::string> command;
    for (std::string word; words >> word;) command.push_back(word);
    has_output = command.at(1) != "view";
    if (has_output) steps.push_back({{command.begin() + 1, command.end()}, {}});
  }
  return steps;
}

// A line with # for each number and single blanks: what is the same on all machines.
std::string without_numbers(const std::string& line) {
  static const std::regex number(R"([-+]?[0-9]+(\.[0-9]+)?(e[-+]?[0-9]+)?)"), blanks("[ \t]+");
  return std::regex_replace(std::regex_replace(line, number, "#"), blanks, " ");
}

// Whether the output has this line of a page, in which "..." stands for any text.
bool shows(const std::string& output_line, const std::string& page_line) {
  const std::string text = without_numbers(output_line), expected = without_numbers(page_line);
  std::size_t at = 0;
  for (std::size_t from = 0; from <= expected.size();) {
    const std::size_t end = std::min(expected.find("...", from), expected.size());
    std::string part = expected.substr(from, end - from);
    if (!part.empty() && part.front() == ' ') part.erase(0, 1);
    if (!part.empty() && part.back() == ' ') part.pop_back();
    at = text.find(part, at);
    if (at == std::string::npos) return false;
    at += part.size();
    from = end + 3;
  }
  return true;
}

// The lines of a page appear in the output of their command in this order.
void runs_as_written(const std::string& name) {
  const std::vector<TutorialStep> steps = tutorial(name);
  ASSERT_FALSE(steps.empty()) << name;
  const Folder folder;
  std::size_t compared = 0;
  for (const auto& [command, output] : steps) {
    SCOPED_TRACE(testing::PrintToString(command));
    const Outcome o = folder.firn(command);
    EXPECT_EQ(o.status, 0) << o.err;
    std::istringstream all(o.err + o.out);
    std::string line;
    for (const std::string& expected : output) {
      bool found = false;
      while (!found && std::getline(all, line)) found = shows(line, expected);
      EXPECT_TRUE(found) << name << ".md: \"" << expected << "\" is not in the output\n"
                         << o.err << o.out;
      ++compared;
    }
  }
  EXPECT_GE(compared, 1u) << name << ".md shows no output";
}

TEST(Tutorials, LinesAreComparedWithoutNumbers) {
  EXPECT_TRUE(shows("slot_count     100      particles", "slot_count 99 ..."));
  EXPECT_TRUE(shows("  energy error -2.6e-15 J", "energy error 0 J"));
  EXPECT_TRUE(shows("a b c d", "a ... d"));
  EXPECT_FALSE(shows("a b c", "a ... d"));
  EXPECT_FALSE(shows("slot_mass 1.37 kg", "slot_mass 1.37 g"));
  EXPECT_FALSE(shows("", "verdict"));
}

TEST(Tutorials, AreAllTested) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(fs::path(FIRN_SOURCE_DIR) / "docs/tutorials"))
    names.push_back(entry.path().stem().string());
  EXPECT_THAT(names, testing::UnorderedElementsAre("angle", "bucket", "first-picture", "heap",
                                                   "load-cell", "lump"));
}
TEST(Tutorials, FirstPicture) { runs_as_written("first-picture"); }
TEST(Tutorials, YourOwnBucket) { runs_as_written("bucket"); }
TEST(Tutorials, YourOwnLumpOfIce) { runs_as_written("lump"); }
TEST(TutorialsLong, YourOwnAngleOfRepose) { runs_as_written("angle"); }
TEST(TutorialsLong, YourOwnIce) { runs_as_written("heap"); }
TEST(TutorialsLong, YourLoadCell) { runs_as_written("load-cell"); }

class Template : public testing::TestWithParam<const char*> {};
TEST_P(Template, RunsAsItsReadmeSays) { runs_as_its_readme_says(GetParam()); }
INSTANTIATE_TEST_SUITE_P(Each, Template, testing::Values("bucket", "hopper", "repose"));

class TemplateLong : public testing::TestWithParam<const char*> {};
TEST_P(TemplateLong, RunsAsItsReadmeSays) { runs_as_its_readme_says(GetParam()); }
INSTANTIATE_TEST_SUITE_P(Each, TemplateLong,
                         testing::Values("drum", "icemaker", "own-angle", "own-study",
                                         "own-validation", "user-simulator"));

}  // namespace
}  // namespace firn::cli
