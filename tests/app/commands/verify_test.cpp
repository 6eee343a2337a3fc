// firn verify: the table, JSON, and the page.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/app/program.h"

namespace firn::cli {
namespace {

using nlohmann::json;
using testing::HasSubstr;

TEST(VerifyCommand, RunsNamedCasesAndListsEveryCheck) {
  const Folder folder;
  const Outcome o = folder.firn({"verify", "impact.two_bodies", "body.free_fall", "--checks"});
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_THAT(o.out, HasSubstr("impact.two_bodies"));
  EXPECT_THAT(o.out, HasSubstr("largest force"));
  EXPECT_THAT(o.out, HasSubstr("holds"));
  EXPECT_THAT(o.err, HasSubstr("2 of 2 cases hold"));
}

TEST(VerifyCommand, JsonHoldsWhatWasComparedAndNothingElseIsThere) {
  const Folder folder;
  const Outcome o = folder.firn({"verify", "impact.two_bodies", "--json"});
  ASSERT_EQ(o.status, 0) << o.err;
  const json document = json::parse(o.out);
  EXPECT_EQ(document["passed"], true);
  const json& check = document["cases"][0]["checks"][0];
  EXPECT_EQ(document["cases"][0]["name"], "impact.two_bodies");
  EXPECT_EQ(check["unit"], "m/s");
  EXPECT_NEAR(check["measured"].get<double>(), check["expected"].get<double>(),
              check["tolerance"].get<double>());
}

TEST(VerifyCommand, ListNamesCasesAndRunsNothing) {
  const Folder folder;
  const Outcome o = folder.firn({"verify", "--list", "body"});
  EXPECT_EQ(o.status, 0) << o.err;
  EXPECT_THAT(o.out, HasSubstr("body.free_fall"));
  EXPECT_THAT(o.out, testing::Not(HasSubstr("impact.")));
}

TEST(VerifyCommand, WritesPagesThatStandAlone) {
  const Folder folder;
  for (const char* page : {"page.html", "page.md"}) {
    const Outcome o = folder.firn({"verify", "body.free_fall", "-o", page});
    ASSERT_EQ(o.status, 0) << o.err;
    const std::string text = read_text(folder.path() / page);
    EXPECT_THAT(text, HasSubstr("A crescent in free fall"));
    EXPECT_THAT(text, HasSubstr("distance from the parabola"));
    EXPECT_THAT(text, HasSubstr("1 of 1 cases hold"));
    EXPECT_THAT(text, testing::Not(HasSubstr("http")));
  }
}

TEST(VerifyCommand, WrongNamesAreReportedInOneLine) {
  const Folder folder;
  const Outcome name = folder.firn({"verify", "impcat"});
  EXPECT_EQ(name.status, 2);
  EXPECT_EQ(lines(name.err), 1u);
  EXPECT_THAT(name.err, HasSubstr("impcat: no such verification case"));
  const Outcome page = folder.firn({"verify", "body.free_fall", "-o", "page.pdf"});
  EXPECT_EQ(page.status, 2);
  EXPECT_THAT(page.err, HasSubstr("page.pdf: a page is FILE.html or FILE.md"));
  const Outcome place = folder.firn({"verify", "body.free_fall", "-o", "nowhere/page.md"});
  EXPECT_EQ(place.status, 2);
  EXPECT_THAT(place.err, HasSubstr("nowhere/page.md: cannot be written"));
}

}  // namespace
}  // namespace firn::cli
