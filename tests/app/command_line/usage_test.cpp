// Help, version, exit statuses, and one line for every mistake.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <regex>
#include <sstream>

#include "experiments/storage/version.h"
#include "firn/contact_model.h"
#include "tests/app/program.h"
#include "tests/support/replaced.h"
#include "tests/support/small_cases.h"

namespace firn::cli {
namespace {

using testing::HasSubstr;
using testing::Not;

using test::replaced;

// Exit status 2, nothing on standard output, one line on standard error.
void expect_one_line(const Outcome& o, const std::string& about) {
  EXPECT_EQ(o.status, 2) << o.err;
  EXPECT_EQ(o.out, "");
  EXPECT_EQ(lines(o.err), 1U) << o.err;
  EXPECT_THAT(o.err, HasSubstr(about));
}

Outcome run_text(const std::string& text) {
  const Folder folder;
  return folder.firn({"run", folder.write("case.toml", text), "-o", "run.h5"});
}

// Names of the help text's list.
std::vector<std::string> subcommands() {
  const std::string help = Folder().firn({"--help"}).out;
  const std::size_t from = help.find("Subcommands:\n");
  std::istringstream list(help.substr(from, help.find("\n\n", from) - from));
  std::vector<std::string> names;
  std::string line;
  std::getline(list, line);
  while (std::getline(list, line)) names.push_back(line.substr(2, line.find(' ', 2) - 2));
  return names;
}

TEST(Usage, HelpListsEverySubCommand) {
  const Outcome o = Folder().firn({"--help"});
  EXPECT_EQ(o.status, 0);
  EXPECT_EQ(o.err, "");
  EXPECT_THAT(o.out, HasSubstr("Exit status"));
  EXPECT_THAT(subcommands(),
              testing::IsSupersetOf({"new", "run", "measure", "calibrate", "shape", "export",
                                     "view", "sweep", "optimize", "validate", "report", "verify",
                                     "contacts", "compare-traces", "materials"}));
}

TEST(Usage, EverySubCommandHasHelpAManualPageAndASection) {
  const Folder folder;
  const std::string install = read_text(std::string(FIRN_SOURCE_DIR) + "/cmake/install.cmake");
  const std::size_t from = install.find("foreach(command \"\" ") + 19;
  std::string pages = " " + install.substr(from, install.find(')', from) - from) + " ";
  std::ranges::replace(pages, '\n', ' ');
  const std::string reference = read_text(std::string(FIRN_SOURCE_DIR) + "/docs/command-line.md");
  for (const std::string& name : subcommands()) {
    const Outcome o = folder.firn({name, "--help"});
    EXPECT_EQ(o.status, 0) << name;
    EXPECT_THAT(o.out, HasSubstr("firn " + name));
    EXPECT_THAT(pages, HasSubstr(" " + name + " "));
    EXPECT_THAT(reference, HasSubstr("\n## firn " + name + "\n"));
  }
}

// Options of the commands on the pages are in the help texts. Those of firn materials belong to its
// sub-commands.
TEST(Usage, CommandsOnThePagesHaveTheirOptions) {
  namespace fs = std::filesystem;
  static const std::regex continued(R"(\\\n *)"), option("[ [](--[a-z][a-z-]*)");
  static const std::regex command(R"((?:^|[\s`/(])firn ([a-z-]+)([^`\n|#&;]*))");
  const Folder folder;
  std::map<std::string, std::string> help;
  for (const std::string& name : subcommands())
    if (name != "materials") help[name] = folder.firn({name, "--help"}).out;
  std::vector<fs::path> pages = {fs::path(FIRN_SOURCE_DIR) / "README.md"};
  for (const char* part : {"docs", "cases"})
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(FIRN_SOURCE_DIR) / part))
      if (entry.path().extension() == ".md") pages.push_back(entry.path());
  int count = 0;
  for (const fs::path& page : pages) {
    const std::string text = std::regex_replace(read_text(page), continued, " ");
    for (std::sregex_iterator c(text.begin(), text.end(), command), end; c != end; ++c) {
      const auto known = help.find((*c)[1]);
      if (known == help.end()) continue;
      const std::string arguments = (*c)[2];
      for (std::sregex_iterator o(arguments.begin(), arguments.end(), option); o != end; ++o) {
        ++count;
        const std::regex whole((*o)[1].str() + "(?![a-z-])");
        EXPECT_TRUE(std::regex_search(known->second, whole)) << page << ": " << (*c)[0];
      }
    }
  }
  EXPECT_GT(count, 100);
}

TEST(Usage, FilesOfAnotherKindAreNamed) {
  const Folder folder;
  folder.write("case.toml", replaced(two_boxes, "50 ms", "1 ms"));
  ASSERT_EQ(folder.firn({"run", "case.toml", "-o", "run.h5", "-q"}).status, 0);
  expect_one_line(folder.firn({"run", "run.h5"}),
                  "run.h5: is a results file (HDF5), which firn run --resume continues; expected");
  folder.write("wide.toml", std::string("\xff\xfe[\0c\0", 6));
  expect_one_line(folder.firn({"run", "wide.toml"}), "wide.toml: is UTF-16 text, as spreadsheets");
}

TEST(Usage, CountsAreWholeNumbersInTheirRange) {
  const Folder folder;
  const std::vector<std::vector<std::string>> commands = {
      {"run", "case.toml", "--seed"},        {"run", "case.toml", "--threads"},
      {"contacts", "case.toml", "--step"},   {"contacts", "case.toml", "--limit"},
      {"contacts", "case.toml", "--every"},  {"compare-traces", "a", "b", "--limit"},
      {"calibrate", "study.toml", "--jobs"}, {"shape", "a.stl", "--max-parts"},
      {"export", "run.h5", "--every"},       {"verify", "--jobs"},
  };
  for (std::vector<std::string> command : commands) {
    const std::string option = command.back();
    for (const char* value : {"-1", "1.5", "x", "", "99999999999999999999", "1e400"}) {
      command.emplace_back(value);
      SCOPED_TRACE(command.front() + ' ' + option + ' ' + value);
      expect_one_line(folder.firn(command), option);
      command.pop_back();
    }
  }
}

// A command with an old name does the same as with the current one, after a warning.
TEST(Usage, OldNamesAreReadWithAWarning) {
  const Folder folder;
  struct Pair {
    std::vector<std::string> old, now;
    std::string from, to;
  };
  std::vector<Pair> pairs = {
      {{"hashes", "a", "b"}, {"compare-traces", "a", "b"}, "hashes", "compare-traces"},
      {{"compare-traces", "a", "b", "--top", "3"},
       {"compare-traces", "a", "b", "--limit", "3"},
       "--top",
       "--limit"},
      {{"contacts", "a.h5", "--top=3"}, {"contacts", "a.h5", "--limit=3"}, "--top", "--limit"},
      {{"export", "a.h5", "--to", "vtk", "--parts"},
       {"export", "a.h5", "--to", "vtk", "--contact-shapes"},
       "--parts",
       "--contact-shapes"},
      {{"shape", "a.stl", "--repaired", "b.stl"},
       {"shape", "a.stl", "--repair-to", "b.stl"},
       "--repaired",
       "--repair-to"},
      {{"calibrate", "a.toml", "--save", "n", "--remark", "t"},
       {"calibrate", "a.toml", "--save", "n", "--note", "t"},
       "--remark",
       "--note"}};
  for (const std::string command : {"calibrate", "sweep", "validate"}) {
    pairs.push_back({{command, "a.toml", "--store", "s.db"},
                     {command, "a.toml", "--cache", "s.db"},
                     "--store",
                     "--cache"});
    pairs.push_back({{command, "a.toml", "--no-store"},
                     {command, "a.toml", "--no-cache"},
                     "--no-store",
                     "--no-cache"});
    pairs.push_back({{command, "a.toml", "--progress", "people"},
                     {command, "a.toml", "--progress", "text"},
                     "--progress people",
                     "--progress text"});
    pairs.push_back({{command, "a.toml", "--progress=people"},
                     {command, "a.toml", "--progress=text"},
                     "--progress people",
                     "--progress text"});
  }
  for (const Pair& pair : pairs) {
    SCOPED_TRACE(pair.old[0] + ' ' + pair.from);
    const Outcome old = folder.firn(pair.old), now = folder.firn(pair.now);
    EXPECT_EQ(old.status, now.status);
    EXPECT_EQ(old.out, now.out);
    EXPECT_EQ(old.err, "firn: warning: \"" + pair.from + "\" is now \"" + pair.to +
                           "\"; the old name is read by this version only\n" + now.err);
    const std::string option = pair.from.substr(0, pair.from.find(' '));
    if (option != "--progress") {
      EXPECT_THAT(folder.firn({pair.now[0], "--help"}).out, Not(HasSubstr(option + ' ')));
    }
  }
}

// The value of an option, and what follows "--", are no names.
TEST(Usage, OldNamesAreReadAsOptionsOnly) {
  EXPECT_THAT(Folder().firn({"shape", "--", "--repaired"}).err, Not(HasSubstr("warning")));
  EXPECT_THAT(Folder().firn({"shape", "hashes"}).err, Not(HasSubstr("warning")));
  EXPECT_THAT(Folder().firn({"run", "case.toml", "--top", "3"}).err, Not(HasSubstr("warning")));
}

TEST(Usage, VersionStatesTheCommit) {
  const Outcome o = Folder().firn({"--version"});
  EXPECT_EQ(o.status, 0);
  EXPECT_EQ(o.out, std::string("firn ") + firn_version() + " (" + firn_git_commit() +
                       "), contact model " + std::to_string(kContactModel) + "\n");
}

TEST(Usage, NothingToDoIsAMistake) {
  const Outcome o = Folder().firn({});
  EXPECT_EQ(o.status, 2);
  EXPECT_EQ(o.out, "");
  EXPECT_THAT(o.err, HasSubstr("Usage"));
}

TEST(Usage, UnknownSubCommand) {
  const Outcome o = Folder().firn({"simulate", "case.toml"});
  expect_one_line(o, "simulate: no such sub-command; expected one of new, run, measure");
}

TEST(Usage, UnknownOption) { expect_one_line(Folder().firn({"run", "--sead", "3"}), "--sead"); }

TEST(Usage, OptionWithoutSense) {
  expect_one_line(Folder().firn({"run", "case.toml", "--threads", "-2"}), "--threads");
}

// One value behind each of them: the file that follows is no further value.
TEST(Usage, RepeatedOptionsTakeOneValueEach) {
  const Folder folder;
  for (const char* command : {"run", "view", "shape", "contacts"})
    expect_one_line(folder.firn({command, "--set", "case.seed=2", "absent.toml"}), "absent.toml");
  for (const char* command : {"run", "view"})
    expect_one_line(folder.firn({command, "--material", "ice", "absent.toml"}), "absent.toml");
}

TEST(Usage, RunNeedsACase) {
  expect_one_line(Folder().firn({"run"}), "expected CASE.toml or --resume");
}

TEST(Usage, AFileOfAnotherKindIsNamed) {
  const struct {
    std::string table, file, command;
  } kinds[] = {{"case", "a case file", "run"},
               {"study", "a study file", "calibrate"},
               {"suite", "a suite file", "validate"},
               {"sweep", "a sweep file", "sweep"},
               {"optimization", "an optimization file", "optimize"}};
  const Folder folder;
  for (const auto& given : kinds) {
    const std::string name = given.table + ".toml";
    folder.write(name, "# about it\n[" + given.table + "]\nname = \"small\"\n[budget]\nruns = 9\n");
    for (const auto& wanted : kinds)
      if (wanted.table != given.table)
        expect_one_line(folder.firn({wanted.command, name}),
                        name + ":2: " + given.table + ": is a file for firn " + given.command +
                            "; expected " + wanted.file + " (firn " + wanted.command + ")");
  }
  // With the table of the expected kind, any other one is an unknown key.
  folder.write("both.toml", "[case]\nduration = \"1 s\"\n[study]\nname = \"small\"\n");
  expect_one_line(folder.firn({"run", "both.toml"}), "both.toml:3: study: unknown key; expected");
}

TEST(Usage, ResumeTakesNoSettings) {
  expect_one_line(Folder().firn({"run", "--resume", "run.h5", "--seed", "2"}), "--resume");
}

TEST(Mistakes, MissingFile) {
  const Folder folder;
  expect_one_line(folder.firn({"run", "nowhere.toml"}), "nowhere.toml");
  expect_one_line(folder.firn({"measure", "nowhere.h5"}), "nowhere.h5");
  expect_one_line(folder.firn({"shape", "nowhere.stl"}), "nowhere.stl");
  expect_one_line(folder.firn({"export", "nowhere.h5", "--to", "csv"}), "nowhere.h5");
  expect_one_line(folder.firn({"calibrate", "nowhere.toml"}), "nowhere.toml");
}

TEST(Mistakes, UnknownKeyNamesTheNearest) {
  const Outcome o = run_text(replaced(two_boxes, "density =", "densty ="));
  expect_one_line(o, "case.toml:6: ");
  EXPECT_THAT(o.err, HasSubstr("density"));
}

TEST(Mistakes, MissingUnit) {
  const Outcome o = run_text(replaced(two_boxes, "\"916.7 kg/m^3\"", "916.7"));
  expect_one_line(o, "case.toml:6: materials.ice.density");
}

TEST(Mistakes, NotToml) { expect_one_line(run_text("[case\nname = 1\n"), "case.toml:1"); }

TEST(Mistakes, NegativeMass) {
  const Outcome o = run_text(
      replaced(two_boxes, "rounding = \"0.5 mm\"", "rounding = \"0.5 mm\"\nmass = \"-13.7 g\""));
  expect_one_line(o, "case.toml:25: shapes.cube.mass");
}

TEST(Mistakes, UnknownMaterial) {
  expect_one_line(run_text(replaced(two_boxes, "material = \"plastic\"", "material = \"brass\"")),
                  "brass");
}

TEST(Mistakes, DoorWiderThanTheBox) {
  expect_one_line(
      run_text(replaced(small_drain, "door_width = \"80 mm\"", "door_width = \"400 mm\"")),
      "door_width");
}

TEST(Mistakes, ImpossibleFill) {
  const Outcome o = run_text(replaced(small_drain, "count = 30", "count = 3000"));
  expect_one_line(o, "case.toml:33: experiment.fill.count");
}

TEST(Mistakes, BadSet) {
  const Folder folder;
  folder.write("case.toml", two_boxes);
  expect_one_line(folder.firn({"run", "case.toml", "--set", "seed"}), "--set");
  expect_one_line(folder.firn({"run", "case.toml", "--set", "case.sede=3"}), "case.sede");
  expect_one_line(folder.firn({"run", "case.toml", "--set", "case.duration=4"}), "case.duration");
}

TEST(Mistakes, BadRequire) {
  const Folder folder;
  folder.write("case.toml", two_boxes);
  for (const char* bound : {"angle", "angle=3", "angle<=", "<=3", "angle<=3 deg"}) {
    expect_one_line(folder.firn({"run", "case.toml", "--require", bound}), "--require");
  }
}

TEST(Mistakes, ResultsFileOfAnotherKind) {
  const Folder folder;
  expect_one_line(folder.firn({"measure", folder.write("run.h5", "no HDF5 at all")}), "run.h5");
}

TEST(Mistakes, UnknownExportFormat) {
  expect_one_line(Folder().firn({"export", "run.h5", "--to", "xlsx"}), "xlsx");
}

TEST(Mistakes, WrittenFolderIsAFile) {
  const Folder folder;
  folder.write("case.toml", two_boxes);
  folder.write("runs", "in the way");
  const Outcome o = folder.firn({"run", "case.toml"});
  EXPECT_EQ(o.status, 2);
  EXPECT_THAT(o.err, HasSubstr("runs"));
}

}  // namespace
}  // namespace firn::cli
