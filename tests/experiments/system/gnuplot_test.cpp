#include "experiments/system/gnuplot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>

#include "experiments/system/text_encoding.h"
#include "firn/math.h"
#include "tests/support/environment.h"
#include "tests/support/error_of.h"
#include "tests/support/read_text.h"
#include "tests/support/scratch_folder.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

// Every way in which a script can show text of the user.
std::string script_with(const std::string& text) {
  const std::string quoted = encode::gnuplot(text);
  return "set title " + quoted + "\nset xlabel " + quoted + "\nset ylabel " + quoted +
         "\nset cblabel " + quoted + "\nset label 1 " + quoted + " at graph 0.5,0.5\nset xtics (" +
         encode::gnuplot_tic(text) + " 1)\nplot [0:2] x title " + quoted + "\n";
}

// Text that executes or changes something when it is not quoted; MARK is a file to be created.
std::vector<std::string> attacks() {
  return {"x\nsystem(\"touch MARK\")\n#",
          "x'\nsystem('touch MARK')\n#",
          "`touch MARK`",
          "\" . system(\"touch MARK\") . \"",
          "' . system('touch MARK') . '",
          "\\\" . system(\"touch MARK\") . \"",
          "\\",
          "x\\\n!touch MARK\n",
          "@GPVAL_PWD",
          "\n!touch MARK",
          "\r!touch MARK\r",
          "EOD\n!touch MARK",
          "$(touch MARK)",
          "%d %s %n %",
          "%%%",
          "{/Symbol a}_^~&@{",
          "\"; system(\"touch MARK\"); \"",
          "]]> ]]]>]]>",
          "<touch MARK",
          "|touch MARK",
          "\033[2J",
          std::string("a\0b", 3),
          "\xff\xfe",
          "\xe2\x80\xae reversed",
          "\\101\\0421\\x41",
          ""};
}

// As the title of a picture shows it: empty when gnuplot refuses the script.
void expect_harmless(const std::string& text) {
  const Gnuplot gnuplot;
  const fs::path picture = gnuplot.data_file("out.svg");
  gnuplot.draw(script_with(text), picture.string(), 400, 300);
  EXPECT_FALSE(fs::exists(gnuplot.data_file("MARK"))) << encode::terminal(text);
  const std::string svg = test::read_text(picture);
  EXPECT_EQ(svg.find("]]>"), std::string::npos);
  if (text.find("]]>") != std::string::npos) return;  // changed
  // Once each as title, axes and key; gnuplot leaves out empty text.
  const std::string shown = encode::markup(encode::terminal(text));
  if (shown.find_first_not_of(' ') == std::string::npos) return;
  // gnuplot escapes < > & only.
  std::string as_gnuplot = encode::terminal(text);
  for (const auto& [from, to] :
       {std::pair<std::string, std::string>{"&", "&amp;"}, {"<", "&lt;"}, {">", "&gt;"}})
    for (std::size_t at = 0; (at = as_gnuplot.find(from, at)) != std::string::npos; at += to.size())
      as_gnuplot.replace(at, from.size(), to);
  std::size_t count = 0;
  for (std::size_t at = 0; (at = svg.find(as_gnuplot, at)) != std::string::npos; ++at) ++count;
  EXPECT_GE(count, 5u) << encode::terminal(text);
}

TEST(Gnuplot, DrawsAPicture) {
  const std::string file = test::scratch_path("gnuplot's picture.png");
  fs::remove(file);
  Gnuplot().draw("plot x\n", file, 200, 100);
  EXPECT_GT(fs::file_size(file), 500u);
}

TEST(Gnuplot, TextOfTheUserIsDrawnAndNeverExecuted) {
  for (const std::string& attack : attacks()) expect_harmless(attack);
}

// Random sequences of the characters that have a meaning somewhere in gnuplot.
TEST(Gnuplot, RandomTextIsDrawnAndNeverExecuted) {
  const std::vector<std::string> pieces = {"\n",
                                           "\"",
                                           "'",
                                           "`",
                                           "\\",
                                           "@",
                                           "%",
                                           "{",
                                           "}",
                                           "_",
                                           "^",
                                           "~",
                                           "&",
                                           "#",
                                           "$",
                                           "!",
                                           "|",
                                           "<",
                                           ";",
                                           ",",
                                           "\r",
                                           "\t",
                                           "0",
                                           "7",
                                           "101",
                                           "x",
                                           "ö",
                                           "[",
                                           "]",
                                           "(",
                                           ")",
                                           "=",
                                           "GPVAL_PWD",
                                           "é",
                                           "\xff",
                                           "touch MARK",
                                           "system(\"touch MARK\")",
                                           "\x1b"};
  std::mt19937 random(20);
  for (int k = 0; k < 40; ++k) {
    std::string text = "a";
    for (std::size_t n = 1 + random() % 12; n > 0; --n) text += pieces[random() % pieces.size()];
    expect_harmless(text + "z");
  }
}

TEST(Gnuplot, NamesOfFilesAreNoCommands) {
  const Gnuplot gnuplot;
  const fs::path folder = gnuplot.data_file("pictures");
  fs::create_directories(folder);
  for (const char* name : {"|touch MARK.svg", "<x.svg", "a'b\"c`d.svg", "%s.svg", "-d.svg"}) {
    gnuplot.draw("plot x\n", (folder / name).string(), 200, 100);
    EXPECT_TRUE(fs::exists(folder / name)) << name;
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 5);
}

TEST(Gnuplot, StartUpFilesOfTheUserAreNotRead) {
  const Gnuplot gnuplot;
  const fs::path home = gnuplot.data_file("home");
  fs::create_directories(home);
  std::ofstream(home / ".gnuplot") << "system(\"touch " << (home / "MARK").string() << "\")\n";
  const test::EnvironmentVariable variable("HOME", home.string());
  gnuplot.run("x = 1\n");
  EXPECT_FALSE(fs::exists(home / "MARK"));
}

TEST(Gnuplot, AWrongScriptIsARunErrorOfOneLine) {
  const Gnuplot gnuplot;
  const std::string message =
      test::error_of<RunError>([&] { gnuplot.run("plot nothing_such(x)\n"); });
  EXPECT_THAT(message, testing::StartsWith("gnuplot: "));
  EXPECT_THAT(message, testing::Not(testing::HasSubstr("\n")));
}

TEST(Gnuplot, MissingProgramIsTheUsersToInstall) {
  const test::EnvironmentVariable nowhere("PATH", "/nowhere");
  EXPECT_THROW(Gnuplot().run("plot x\n"), InputError);
}

// The PATH with a folder first in which gnuplot is this script.
std::string path_with_gnuplot(const fs::path& folder, const std::string& script) {
  std::ofstream(folder / "gnuplot") << "#!/bin/sh\n" << script;
  fs::permissions(folder / "gnuplot", fs::perms::owner_all);
  return folder.string() + ":" + std::getenv("PATH");
}

TEST(Gnuplot, ADrawingThatASignalEndsIsRepeated) {
  const test::ScratchFolder folder("gnuplot-signal");
  for (const int signal : {2, 9, 15}) {
    const std::string once = folder / "once";
    fs::remove(once);
    const test::EnvironmentVariable killed(
        "PATH", path_with_gnuplot(folder.path(), "test -e '" + once + "' && exit 0\ntouch '" +
                                                     once + "'\nkill -" + std::to_string(signal) +
                                                     " $$\nsleep 9\n"));
    EXPECT_NO_THROW(Gnuplot().run("plot x\n")) << signal;
  }
}

TEST(Gnuplot, ASignalIsNamed) {
  const test::ScratchFolder folder("gnuplot-signal");
  const test::EnvironmentVariable killed("PATH",
                                         path_with_gnuplot(folder.path(), "kill -9 $$\nsleep 9\n"));
  EXPECT_EQ(test::error_of<RunError>([] { Gnuplot().run("plot x\n"); }),
            "gnuplot: signal 9 (Killed) has ended it");
}

TEST(Gnuplot, KnowsPngAndSvgOnly) {
  EXPECT_NO_THROW(Gnuplot::check_picture("a.svg"));
  EXPECT_THROW(Gnuplot::check_picture("a.jpg"), InputError);
}

TEST(Gnuplot, APictureThatCannotBeWrittenIsAnInputError) {
  EXPECT_THROW(Gnuplot().draw("plot x\n", "/nowhere/a.svg", 200, 100), InputError);
}

TEST(Gnuplot, TheFolderGoesWithTheObject) {
  fs::path folder;
  {
    const Gnuplot gnuplot;
    folder = gnuplot.data_file("x").parent_path();
    EXPECT_TRUE(fs::exists(folder));
  }
  EXPECT_FALSE(fs::exists(folder));
}

}  // namespace
}  // namespace firn
