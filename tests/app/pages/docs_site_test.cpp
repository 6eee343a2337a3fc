// The documentation as a site: scripts/build-docs.sh. The build fails for every link without a
// target.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <regex>

#include "tests/support/read_text.h"
#include "tests/support/scratch_folder.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

TEST(DocsSite, IsCompleteAndLoadsNothingFromOutside) {
  const test::ScratchFolder folder("docs-site");
  const std::string script = FIRN_SOURCE_DIR "/scripts/build-docs.sh";
  const std::string log = folder.path() / "log";
  const std::string site = folder.path() / "site";
  ASSERT_EQ(std::system(("'" + script + "' '" + site + "' >'" + log + "' 2>&1").c_str()), 0)
      << test::read_text(log);

  const std::string index = test::read_text(fs::path(site) / "searchindex.js");
  for (const char* word : {"restitut", "hopper", "auger"})  // stems
    EXPECT_THAT(index, testing::HasSubstr(word));

  const std::regex loaded(R"(<(?:script|link|img|iframe)\b[^>]*\b(?:src|href)="(?:https?:)?//)");
  int pages = 0;
  for (const auto& page : fs::recursive_directory_iterator(fs::path(FIRN_SOURCE_DIR) / "docs")) {
    if (page.path().extension() != ".md") continue;
    ++pages;
    const fs::path html =
        site / fs::relative(page.path(), FIRN_SOURCE_DIR).replace_extension(".html");
    ASSERT_TRUE(fs::exists(html)) << html;
    EXPECT_FALSE(std::regex_search(test::read_text(html), loaded)) << html;
  }
  EXPECT_GT(pages, 25);
}

}  // namespace
}  // namespace firn
