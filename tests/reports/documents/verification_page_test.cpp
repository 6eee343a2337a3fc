#include "reports/documents/verification_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/read_text.h"
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
  return test::read_text(file);
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

TEST(VerificationPage, NegligibleValuesAreZero) {
  const Check turn{"turn", -3.6e-25, 0, 1e-9, Bound::absolute, "rad"};
  EXPECT_EQ(measured_value_text(turn), "0 rad");
  EXPECT_EQ(used_text(tolerance_fraction(turn)), "0 %");
  const Check small{"turn", -3.6e-10, 0, 1e-9, Bound::absolute, "rad"};
  EXPECT_EQ(measured_value_text(small), "-3.6e-10 rad");
  EXPECT_EQ(used_text(tolerance_fraction(small)), "36 %");
  EXPECT_EQ(measured_value_text({"loss", 4e-22, 1e-12, 0, Bound::at_most, "J"}), "0 J");
  EXPECT_EQ(measured_value_text({"loss", 4e-13, 1e-12, 0, Bound::at_most, "J"}), "4e-13 J");
  EXPECT_EQ(measured_value_text({"load", 2.5, 2.4, 0.1, Bound::relative, "N"}), "2.5 N");
}

}  // namespace
}  // namespace firn
