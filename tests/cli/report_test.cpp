// firn report.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/cli/cases.h"
#include "tests/cli/program.h"

namespace firn::cli {
namespace {

using testing::HasSubstr;

TEST(ReportCommand, APageOfARunLiesBesideIt) {
  const Folder folder;
  folder.write("case.toml", two_boxes);
  ASSERT_EQ(folder.firn({"run", "case.toml", "-o", "two.h5"}).status, 0);
  const Outcome o = folder.firn({"report", "two.h5"});
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_EQ(o.out, "two.html\n");
  EXPECT_THAT(read_text(folder.path() / "two.html"), HasSubstr("<h1>two boxes</h1>"));
  const Outcome json = folder.firn({"report", "two.h5", "-o", "other.html", "--json"});
  EXPECT_EQ(json.out, "{\"report\":\"other.html\"}\n");
  EXPECT_TRUE(folder.contains("other.html"));
}

TEST(ReportCommand, PlotsAreFilesOfTheirOwn) {
  const Folder folder;
  folder.write("case.toml", two_boxes);
  ASSERT_EQ(folder.firn({"run", "case.toml", "-o", "two.h5"}).status, 0);
  const Outcome o = folder.firn({"report", "two.h5", "--figures", "plots"});
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_THAT(o.out, HasSubstr("plots/energy.svg\n"));
  const std::string svg = read_text(folder.path() / "plots/energy.svg");
  EXPECT_THAT(svg, HasSubstr("--series-1: #"));  // as the page has it, without the page
  EXPECT_THAT(svg, testing::EndsWith("</svg>\n"));
  folder.write("taken", "a file\n");
  EXPECT_EQ(folder.firn({"report", "two.h5", "--figures", "taken"}).status, 2);
}

TEST(ReportCommand, WhatIsNoResultsFileIsOneLineOfAnError) {
  const Folder folder;
  folder.write("text.h5", "no results\n");
  for (const char* name : {"text.h5", "missing.h5", "missing"}) {
    const Outcome o = folder.firn({"report", name});
    EXPECT_EQ(o.status, 2) << name;
    EXPECT_EQ(lines(o.err), 1U) << o.err;
    EXPECT_THAT(o.err, HasSubstr(name));
  }
}

}  // namespace
}  // namespace firn::cli
