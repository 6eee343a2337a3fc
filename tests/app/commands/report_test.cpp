// firn report.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "tests/app/program.h"
#include "tests/support/small_cases.h"

namespace firn::cli {
namespace {

using testing::HasSubstr;

TEST(ReportCommand, APageOfARunIsInItsFolder) {
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

TEST(ReportCommand, APageOnPaperNeedsABrowserThatWorks) {
  const Folder folder;
  folder.write("case.toml", two_boxes);
  ASSERT_EQ(folder.firn({"run", "case.toml", "-o", "two.h5"}).status, 0);
  // A PATH with gnuplot alone, then with a browser that does what the script says.
  const std::filesystem::path programs = folder.path() / "programs";
  std::filesystem::create_directory(programs);
  for (const char* place : {"/usr/bin/gnuplot", "/usr/local/bin/gnuplot"})
    if (std::filesystem::exists(place) && !std::filesystem::exists(programs / "gnuplot"))
      std::filesystem::create_symlink(place, programs / "gnuplot");
  const auto report = [&] {
    return folder.wait(folder.start({"report", "two.h5", "-o", "two.pdf"},
                                    [&] { setenv("PATH", programs.c_str(), 1); }));
  };
  const auto browser = [&](const std::string& script) {
    folder.write("programs/chromium", "#!/bin/sh\n" + script);
    std::filesystem::permissions(programs / "chromium", std::filesystem::perms::owner_all);
  };
  const Outcome none = report();
  EXPECT_EQ(none.status, 2);
  EXPECT_EQ(lines(none.err), 1U) << none.err;
  EXPECT_THAT(none.err, HasSubstr("a PDF needs the program chromium"));
  for (const char* script : {"exit 0\n", "echo it crashed >&2; exit 3\n",
                             "for a; do case $a in --print-to-pdf=*) printf '%%PDF-1.4 cut' > "
                             "\"${a#*=}\";; esac; done\n"}) {
    browser(script);
    const Outcome bad = report();
    EXPECT_EQ(bad.status, 1) << script;
    EXPECT_EQ(lines(bad.err), 1U) << bad.err;
    EXPECT_THAT(bad.err, HasSubstr("chromium: printed no whole PDF"));
    EXPECT_FALSE(folder.contains("two.pdf"));
  }
  browser(
      "for a; do case $a in --print-to-pdf=*) printf '%%PDF-1.4 good %%%%EOF\\n' > "
      "\"${a#*=}\";; esac; done\n");
  const Outcome good = report();
  EXPECT_EQ(good.status, 0) << good.err;
  EXPECT_EQ(good.out, "two.pdf\n");
  EXPECT_EQ(read_text(folder.path() / "two.pdf"), "%PDF-1.4 good %%EOF\n");
}

// The real browser, where it is installed.
TEST(ReportCommandLong, APageIsPrinted) {
  if (std::system("command -v chromium >/dev/null") != 0)
    GTEST_SKIP() << "chromium is not installed: no page is printed";
  const Folder folder;
  folder.write("case.toml", two_boxes);
  ASSERT_EQ(folder.firn({"run", "case.toml", "-o", "two.h5"}).status, 0);
  const Outcome o = folder.firn({"report", "two.h5", "-o", "two.pdf"});
  ASSERT_EQ(o.status, 0) << o.err;
  const std::string pdf = read_text(folder.path() / "two.pdf");
  EXPECT_TRUE(pdf.starts_with("%PDF-"));
  EXPECT_GT(pdf.size(), 10000U);
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
  folder.write("case.toml", two_boxes);
  for (const char* name : {"text.h5", "missing.h5", "missing", "case.toml"}) {
    const Outcome o = folder.firn({"report", name});
    EXPECT_EQ(o.status, 2) << name;
    EXPECT_EQ(lines(o.err), 1U) << o.err;
    EXPECT_THAT(o.err, HasSubstr(name));
  }
}

}  // namespace
}  // namespace firn::cli
