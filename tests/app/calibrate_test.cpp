// firn calibrate: what it prints at its end.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>
#include <vector>

#include "tests/app/hostile_inputs.h"
#include "tests/app/program.h"

namespace firn::cli {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

TEST(CalibrateCommand, EndsWithFiveLines) {
  const Folder folder;
  folder.write("case.toml", hostile::rich_case);
  folder.write("study.toml", hostile::study_file);
  const Outcome o = folder.firn({"calibrate", "study.toml", "--no-store", "--progress", "none"});
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

}  // namespace
}  // namespace firn::cli
