#include "reports/documents/sweep_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/reports/damaged_json.h"
#include "tests/support/results_folder.h"

namespace firn {
namespace {

using testing::HasSubstr;
using testing::Not;

// What firn sweep leaves: a number with a unit, words, and one failed run.
constexpr const char* kSweepResults = R"({
 "kind": "sweep", "name": "ice & <steel>", "case": "case.toml",
 "responses": [{"name": "peak_force", "unit": "N"}, {"name": "count", "unit": "1"}],
 "combinations": [
  {"values": {"modulus": "0.01 GPa", "kind": "cube"},
   "responses": {"peak_force": {"mean": 11.432, "standard_deviation": 1.2, "runs": 2},
                 "count": {"mean": 5, "standard_deviation": null, "runs": 1}}},
  {"values": {"modulus": "0.01 GPa", "kind": "ball"},
   "responses": {"peak_force": {"mean": 13, "standard_deviation": 1.1, "runs": 2},
                 "count": {"mean": 5, "standard_deviation": null, "runs": 1}}},
  {"values": {"modulus": "1 GPa", "kind": "cube"},
   "responses": {"peak_force": {"mean": 110, "standard_deviation": 9, "runs": 2},
                 "count": {"mean": 5, "standard_deviation": null, "runs": 1}}},
  {"values": {"modulus": "1 GPa", "kind": "ball"},
   "responses": {"peak_force": {"mean": null, "standard_deviation": null, "runs": 0},
                 "count": {"mean": null, "standard_deviation": null, "runs": 0}}}],
 "powers": {"peak_force": {"exponent": 0.5, "standard_error": 0.02}},
 "runs": [
  {"combination": 0, "seed": 1, "key": "a", "status": "finished", "reason": "", "wall": 1,
   "values": [11, 5], "results_file": "a.h5"},
  {"combination": 3, "seed": 1, "key": "b", "status": "failed", "reason": "too <soft>", "wall": 1,
   "values": [null, null], "results_file": "b.h5"}]
})";

// The same with the effects of a screening.
test::Json screened() {
  test::Json j = test::Json::parse(kSweepResults);
  j.erase("powers");
  j["effects"] = test::Json::parse(R"({"peak_force": {
    "kind": {"mean_absolute": 91.2, "interval_95": [70.5, 112], "mean": -3.25,
             "standard_deviation": 12, "noise": 4.5, "count": 4},
    "modulus": {"mean_absolute": 2, "interval_95": [null, null], "mean": 2,
                "standard_deviation": null, "noise": null, "count": 1}}})");
  return j;
}

class SweepPage : public ResultsFolder {
 protected:
  std::string file(const std::string& text) const {
    std::ofstream(path("results.json")) << text;
    return path("results.json");
  }
};

TEST_F(SweepPage, HasPlotsATableAndWhatFailed) {
  const std::string html = sweep_page(read_results_json(file(kSweepResults))).html();
  for (const char* part :
       {"ice &amp; &lt;steel&gt;", "1 of 2 runs finished", "peak force over modulus",
        "peak force by kind", "modulus / GPa", "peak force / N", "11.4 ± 1.2", "0.500 ± 0.020",
        "The same in all combinations: count.", "too &lt;soft&gt;", "modulus 1 GPa, kind ball",
        "0 of 1"})
    EXPECT_THAT(html, HasSubstr(part)) << part;
  EXPECT_THAT(html, Not(HasSubstr("peak_force")));  // words, not keys
  EXPECT_THAT(html, Not(HasSubstr("href=\"http")));
}

// The errors that the page explains are in its plots of values that are no numbers, too.
TEST_F(SweepPage, BarsHaveTheDeviationsOfSingleRuns) {
  const auto lines_of_bars = [&](const std::string& results) {
    const std::string html = sweep_page(read_results_json(file(results))).html();
    const std::size_t end = html.find("peak force by kind, mean over");
    EXPECT_NE(end, std::string::npos);
    const std::string plot = html.substr(html.rfind("<svg", end), end - html.rfind("<svg", end));
    int lines = 0;
    for (std::size_t at = plot.find("<path"); at != std::string::npos;
         at = plot.find("<path", at + 1))
      ++lines;
    return lines;
  };
  test::Json single = test::Json::parse(kSweepResults);
  for (auto& c : single["combinations"])
    c["responses"]["peak_force"]["standard_deviation"] = nullptr;
  EXPECT_GT(lines_of_bars(kSweepResults), lines_of_bars(single.dump()));
}

TEST_F(SweepPage, RanksTheFactorsOfAScreening) {
  const std::string html = sweep_page(read_results_json(file(screened().dump()))).html();
  for (const char* part :
       {"Which factor matters", "Effects on peak force", "peak force depends most on kind",
        "70.5 to 112", "mean absolute effect on peak force / N", "noise"})
    EXPECT_THAT(html, HasSubstr(part)) << part;
  EXPECT_THAT(html, Not(HasSubstr("peak force over modulus")));
  EXPECT_THAT(html, Not(HasSubstr("nan")));
}

TEST_F(SweepPage, NamesFactorsInWordsWithUnits) {
  std::string text = screened().dump();
  for (std::size_t at = 0; (at = text.find("\"modulus\"", at)) != text.npos; at += 3)
    text.replace(at, 9, "\"young_modulus\"");
  const std::string html = sweep_page(read_results_json(file(text))).html();
  EXPECT_THAT(html, HasSubstr("young modulus / GPa"));
  EXPECT_THAT(html, Not(HasSubstr("young_modulus")));
}

TEST_F(SweepPage, DoesNotRankASingleFactor) {
  test::Json j = screened();
  j["effects"]["peak_force"].erase("modulus");
  const std::string html = sweep_page(read_results_json(file(j.dump()))).html();
  EXPECT_THAT(html, HasSubstr("One factor is varied"));
  EXPECT_THAT(html, Not(HasSubstr("<figure>")));
}

TEST_F(SweepPage, DistinguishesConstantFromMissingResponses) {
  test::Json j = test::Json::parse(kSweepResults);
  for (test::Json& one : j["combinations"]) one["responses"]["count"]["mean"] = nullptr;
  const std::string html = sweep_page(read_results_json(file(j.dump()))).html();
  EXPECT_THAT(html, HasSubstr("Without a value, since no run came to what it measures: count."));
  EXPECT_THAT(html, Not(HasSubstr("The same in all combinations")));
}

// A curve for each choice of the other keys; many of them are points.
TEST_F(SweepPage, DrawsManyCombinationsAsPoints) {
  test::Json j = test::Json::parse(kSweepResults);
  const test::Json row = j["combinations"][0];
  j["combinations"] = test::Json::array();
  for (int other = 0; other < 20; ++other)
    for (const char* modulus : {"0.01 GPa", "0.1 GPa"}) {
      test::Json one = row;
      one["values"]["modulus"] = modulus;
      one["values"]["kind"] = "kind " + std::to_string(other);
      one["responses"]["peak_force"]["mean"] = 3 * other + modulus[2];
      j["combinations"].push_back(one);
    }
  const std::string html = sweep_page(read_results_json(file(j.dump()))).html();
  EXPECT_THAT(html, HasSubstr("peak force over modulus"));
  EXPECT_THAT(html, HasSubstr("kind 19"));
}

TEST_F(SweepPage, NeedsNoKeyThatIsVaried) {
  test::Json j = test::Json::parse(kSweepResults);
  test::Json one = j["combinations"][0];
  one["values"] = test::Json::object();
  j["combinations"] = {one};
  j["runs"][1]["combination"] = 0;
  EXPECT_THAT(sweep_page(read_results_json(file(j.dump()))).html(), HasSubstr("11.4 ± 1.2"));
}

TEST_F(SweepPage, RefusesWhatIsNoResult) {
  EXPECT_THROW(sweep_page(read_results_json(path("none.json"))), InputError);
  EXPECT_THROW(sweep_page(read_results_json(file("{}"))), InputError);
  EXPECT_THROW(sweep_page(read_results_json(file("[]"))), InputError);
  EXPECT_THROW(sweep_page(read_results_json(file("{\"kind\": \"sweep\"}"))), InputError);
}

TEST_F(SweepPage, TakesOrRefusesWhatIsDamaged) {
  for (const test::Json& whole : {test::Json::parse(kSweepResults), screened()})
    test::damage(whole, 60, [&](const std::string& text) {
      sweep_page(read_results_json(file(text))).html();
    });
}

class SweepPageLong : public SweepPage {};

TEST_F(SweepPageLong, TakesOrRefusesAllThatIsDamaged) {
  for (const test::Json& whole : {test::Json::parse(kSweepResults), screened()})
    test::damage(whole, 0, [&](const std::string& text) {
      sweep_page(read_results_json(file(text))).html();
    });
}

}  // namespace
}  // namespace firn
