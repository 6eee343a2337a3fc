#include "reports/documents/verification_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "tests/support/scratch_folder.h"

namespace firn {
namespace {

using namespace verification;
using testing::HasSubstr;

std::string page(const std::string& name) {
  const std::vector<VerificationCase> cases = {
      {"body.good", "A good one", "a < b & c", "", Tier::quick, {}},
      {"body.bad", "A bad one", "x | y", "", Tier::quick, {}},
      {"body.broken", "A broken one", "z", "", Tier::quick, {}},
      {"bulk.later", "A later one", "z", "", Tier::full, {}}};
  std::vector<CaseResult> results(4);
  results[0] = {{{"weight", 1.0, 1.0, 0.1, Bound::relative, "N"}}, "", 1, true};
  results[1] = {{{"height", 3.0, 2.0, 0, Bound::at_most, "m"}}, "", 1, true};
  results[2] = {{}, "no room for particle 3", 1, true};
  const std::string file = test::scratch_path(name);
  write_verification_page(cases, results, "firn 0", file);
  std::stringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

TEST(VerificationPage, ListsWhatHoldsFailsBrokeAndHasNotRun) {
  for (const char* name : {"page.html", "page.md"}) {
    const std::string text = page(name);
    EXPECT_THAT(text, HasSubstr("1 of 4 cases hold, with 1 of 2 checks; 1 have not run"));
    EXPECT_THAT(text, HasSubstr("fails"));
    EXPECT_THAT(text, HasSubstr("no room for particle 3"));
    EXPECT_THAT(text, HasSubstr("not run"));
  }
}

TEST(VerificationPage, EscapesWhatItsFormatWouldRead) {
  EXPECT_THAT(page("page.html"), HasSubstr("a &lt; b &amp; c"));
  EXPECT_THAT(page("page.md"), HasSubstr("x \\| y"));
}

}  // namespace
}  // namespace firn
