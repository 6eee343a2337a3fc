// firn calibrate: what it prints at its end.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>
#include <vector>

#include "tests/app/program.h"
#include "tests/app/robustness/hostile_inputs.h"
#include "tests/support/replaced.h"

namespace firn::cli {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

TEST(CalibrateCommand, EndsWithFiveLines) {
  const Folder folder;
  folder.write("case.toml", hostile::rich_case);
  folder.write("study.toml", hostile::study_file);
  const Outcome o = folder.firn({"calibrate", "study.toml", "--no-cache", "--progress", "none"});
  ASSERT_EQ(o.status, 0) << o.err;
  std::vector<std::string> all;
  std::istringstream text(o.out);
  for (std::string line; std::getline(text, line);) all.push_back(line);
  ASSERT_GT(all.size(), 6u);
  const std::vector<std::string> last(all.end() - 5, all.end());
  EXPECT_THAT(last[0], StartsWith("Recommended:  rho = "));
  EXPECT_THAT(last[0], HasSubstr(" kg/m^3 (95 %: "));
  EXPECT_THAT(last[1], StartsWith("Determined:   1.00 rho = "));
  EXPECT_THAT(last[1], HasSubstr("Not determined: "));
  EXPECT_THAT(last[2], StartsWith("Compared:     paper: present_mass "));
  EXPECT_THAT(last[3], StartsWith("Measure next: "));
  EXPECT_EQ(last[4], "Report:       runs/study/report.html");
  EXPECT_THAT(read_text(folder.path() / "runs/study/report.html"), HasSubstr("<h1>"));
}

TEST(CalibrateCommand, NamesTheParameterWhoseKeyTheCaseLacks) {
  const Folder folder;
  folder.write("case.toml", hostile::rich_case);
  folder.write("study.toml", test::replaced(hostile::study_file, "materials.ice.density",
                                            "materials.ice.densty"));
  const Outcome o = folder.firn({"calibrate", "study.toml", "--no-cache", "--progress", "none"});
  EXPECT_EQ(o.status, 2);
  EXPECT_EQ(lines(o.err), 1u) << o.err;
  EXPECT_THAT(o.err, HasSubstr("study.toml:15: parameters.rho.keys: the case case.toml has no key "
                               "\"materials.ice.densty\"; did you mean \"density\"?"));
}

// A study starts no program unless the user says so, and nothing of it is made before.
TEST(CalibrateCommand, StartsProgramsOnlyWhenAllowed) {
  const Folder folder;
  ASSERT_EQ(folder.firn({"new", "plate", "--from", "user-simulator"}).status, 0);
  const std::vector<std::string> command = {"calibrate", "plate/study.toml", "--no-cache",
                                            "--progress", "none"};
  const Outcome refused = folder.firn(command);
  EXPECT_EQ(refused.status, 2);
  EXPECT_EQ(lines(refused.err), 1u) << refused.err;
  EXPECT_THAT(refused.err, HasSubstr("plate/study.toml:12: experiments.plate.program: "));
  EXPECT_THAT(refused.err, HasSubstr("--allow-programs"));
  EXPECT_FALSE(folder.contains("runs"));
  std::vector<std::string> allowed = command;
  allowed.push_back("--allow-programs");
  const Outcome done = folder.firn(allowed);
  EXPECT_EQ(done.status, 0) << done.err;
  EXPECT_THAT(done.out, HasSubstr("calibrated: friction = "));
  const Outcome compared = folder.firn({"calibrate", "--compare", "runs/plate", "runs/plate"});
  EXPECT_EQ(compared.status, 0) << compared.err;
  EXPECT_THAT(compared.out, HasSubstr("restitution"));
  EXPECT_THAT(compared.out, HasSubstr("100 %"));
}

TEST(CalibrateCommand, ComparesStudiesAlone) {
  const Folder folder;
  for (const std::vector<std::string>& wrong : {std::vector<std::string>{"calibrate"},
                                                {"calibrate", "--compare", "one"},
                                                {"calibrate", "--compare", "one", "two"}}) {
    const Outcome o = folder.firn(wrong);
    EXPECT_EQ(o.status, 2);
    EXPECT_EQ(lines(o.err), 1u) << o.err;
  }
}

}  // namespace
}  // namespace firn::cli
