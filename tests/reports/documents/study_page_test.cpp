#include "reports/documents/study_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/reports/browser.h"
#include "tests/reports/damaged_json.h"
#include "tests/support/error_of.h"
#include "tests/support/fake_experiment.h"
#include "tests/support/phone_layout.h"
#include "tests/support/results_folder.h"

namespace firn {
namespace {

using testing::HasSubstr;
using testing::Not;

// What firn calibrate leaves, cut to what a page needs.
constexpr const char* kResults = R"({
 "study": "heap & <cubes>", "verdict": "undetermined", "headline": "a valley",
 "targets": [{"response": "angle", "value": 10, "uncertainty": 1, "unit": "deg", "source": "s",
              "reach": {"lowest": 2, "highest": 30},
              "posterior_predictive": {
               "probabilities": [0.025, 0.16, 0.5, 0.84, 0.975],
               "mean_response": {"quantiles": [8.1, 9.1, 10.2, 11.1, 12.1],
                "histogram": {"edges": [7, 9, 11, 13], "probability": [0.2, 0.6, 0.2]}},
               "single_run": {"quantiles": [6.3, 8.2, 10.2, 12.2, 14.3],
                "histogram": {"edges": [5, 10, 15], "probability": [0.5, 0.5]}}}}],
 "estimate_history": [
  {"after": "design", "runs": 13, "parameters": {
   "a": {"median": 0.07, "interval_68": [0.03, 0.12], "interval_95": [0.02, 0.2]},
   "b": {"median": 0.3, "interval_68": [0.2, 0.35], "interval_95": [0.1, 0.4]}}},
  {"after": "confirmation", "runs": 20, "parameters": {
   "a": {"median": 0.055, "interval_68": [0.03, 0.08], "interval_95": [0.02, 0.1]},
   "b": {"median": 0.2, "interval_68": [0.15, 0.25], "interval_95": [0.1, 0.3]}}}],
 "parameters": [
  {"name": "a", "keys": ["x.y"], "min": 0.02, "max": 0.2, "unit": "1", "scale": "log",
   "median": 0.055, "interval_95": [0.02, 0.1], "width_ratio": 0.5, "at_min": true, "at_max": false,
   "profile": {"interval_95": [0.02, 0.1], "values": [0.02, 0.05, 0.2],
               "minus_twice_log_likelihood": [3, 2, 9]}},
  {"name": "b", "keys": ["x.z"], "min": 0.1, "max": 0.4, "unit": "1", "scale": "linear",
   "median": 0.2, "interval_95": [0.1, 0.3], "width_ratio": 0.9}],
 "combinations": [
  {"identified": true, "terms": [{"parameter": "a", "of": "logarithm", "coefficient": 0.5},
                                 {"parameter": "b", "of": "value", "coefficient": 0.9}],
   "value": -3.27, "uncertainty": 0.12},
  {"identified": false, "terms": [{"parameter": "a", "of": "logarithm", "coefficient": 0.8}],
   "value": null, "uncertainty": null}],
 "answer": {"name": "answer", "parameters": {"a": 0.05, "b": 0.2},
            "fit": {"angle": {"value": 10.1, "uncertainty": 0.9, "unit": "deg"}},
            "simulated": {"angle": {"value": 11.4, "standard_error": 1.2, "unit": "deg"}}},
 "valley": [{"name": "member 1", "parameters": {"a": 0.02, "b": 0.3}}],
 "sensitivity": [{"response": "angle", "parameters": {
   "a": {"first": 0.4, "first_interval_95": [0.31, 0.47], "total": 0.45,
         "total_interval_95": [0.36, 0.52]},
   "b": {"first": 0.6}}}],
 "measure_next": [{"response": "height", "uncertainty": 0.01, "unit": "m",
                   "information_bits": 0.38, "longest_direction_left": 0.76,
                   "effort_seconds": 1260}],
 "refinement": {"rounds": 2, "stopped": "the runs are used"},
 "runs": {"total": 20, "finished": 19, "failed": 0, "cut_short": []}
})";

class StudyPage : public ResultsFolder {
 protected:
  std::string file(const std::string& text) const {
    std::ofstream(path("results.json")) << text;
    return path("results.json");
  }
};

TEST_F(StudyPage, ShowsWhatIsKnownAndIsSelfContained) {
  const std::string html = study_page(read_results_json(file(kResults))).html();
  for (const char* part :
       {"heap &amp; &lt;cubes&gt;", "its lower bound limits it", "0.50 ln(a) + 0.90 b",
        "-3.27 ± 0.12", "limited by the range only", "11.4 ± 1.2", "10.10 ± 0.90", "member 1",
        "the runs are used", "0.38", "2 to 30"})
    EXPECT_THAT(html, HasSubstr(part)) << part;
  // One answer: the card has what the answer has, not the median.
  EXPECT_THAT(html, HasSubstr("<span class=\"label\">a</span><b>0.05</b>"));
  for (const char* line : {"Recommended", "a = 0.05 (95 %: 0.02 to 0.1); b = 0.2", "Measure next",
                           "height: 0.38 bits"})
    EXPECT_THAT(html, HasSubstr(line)) << line;
  for (const char* link : {"src=\"http", "href=\"http", "url(http", "@import"})
    EXPECT_THAT(html, Not(HasSubstr(link)));
}

TEST_F(StudyPage, ShowsPredictionsHistoryAndSensitivity) {
  const std::string html = study_page(read_results_json(file(kResults))).html();
  for (const char* part :
       {"Predicted responses",
        "angle: measured 10.0 ± 1.0 deg; mean response 10.2 deg, 95 % 8.1 to 12.1; single run 10.2 "
        "deg, 95 % 6.3 to 14.3",
        "8.2 to 12.2", "Estimate by number of runs",
        "a: 0.07 after 13 runs, 0.055 after 20 runs, 95 % 0.02 to 0.1", "confirmation",
        "first-order Sobol index", "angle by a: 0.4 (0.31 to 0.47). angle by b: 0.6.",
        "total Sobol index", "angle by a: 0.45 (0.36 to 0.52)."})
    EXPECT_THAT(html, HasSubstr(part)) << part;
}

TEST_F(StudyPage, StatesTheDiscrepancyOfATarget) {
  test::Json j = test::Json::parse(kResults);
  EXPECT_THAT(study_page(read_results_json(file(j.dump()))).html(), Not(HasSubstr("discrepancy")));
  j["targets"][0]["discrepancy"] = 1.5;
  EXPECT_THAT(study_page(read_results_json(file(j.dump()))).html(),
              HasSubstr("10.0 ± 1.0 deg, discrepancy of the simulation ± 1.5 deg"));
}

TEST_F(StudyPage, DrawsRecordedCurves) {
  test::Json j = test::Json::parse(kResults);
  j["curves"] = test::Json::parse(R"([{
   "curve": "press", "unit": "N", "x_unit": "s", "explained_variance": 0.993,
   "recorded_rest": 0.12, "x": [0, 1, 2], "recorded": [1, 5, 6], "simulated_mean": [1, 4, 5],
   "components": [[0, 1, 1]]}])");
  std::string html = study_page(read_results_json(file(j.dump()))).html();
  for (const char* part :
       {"press: 1 principal components hold 99.3 %", "leave of the recorded curve: 0.12 N"})
    EXPECT_THAT(html, HasSubstr(part)) << part;
  EXPECT_THAT(html, Not(HasSubstr("model at the answer")));
  j["answer"]["fit"]["press.score_1"] = {{"value", 0.9}, {"uncertainty", 0.1}, {"unit", "N"}};
  html = study_page(read_results_json(file(j.dump()))).html();
  EXPECT_THAT(html, HasSubstr("model at the answer"));
  for (const char* damaged :
       {"/curves/0/recorded", "/curves/0/components/0", "/curves/0/x", "/curves/0/x_unit"}) {
    test::Json broken = j;
    broken[test::Json::json_pointer(damaged)] = test::Json::array({1});
    EXPECT_THROW(study_page(read_results_json(file(broken.dump()))).html(), InputError) << damaged;
  }
}

TEST_F(StudyPage, ListsTheChoicesOfAParameter) {
  test::Json j = test::Json::parse(kResults);
  j["choice"] = test::Json::parse(R"({
   "parameter": "law", "keys": ["x.law"], "best": "<linear>", "choices": [
    {"choice": "<linear>", "prior": 0.4, "probability": 0.973, "verdict": "calibrated", "headline": "",
     "parameters": {"a": {"median": 0.055, "interval_68": [0.03, 0.08], "interval_95": [0.02, 0.1]},
                    "b": {"median": 0.2, "interval_68": [0.15, 0.25], "interval_95": [0.1, 0.3]}}},
    {"choice": "none", "prior": 0.6, "probability": null, "verdict": "too few runs",
     "headline": ""}]})");
  const std::string html = study_page(read_results_json(file(j.dump()))).html();
  for (const char* part :
       {"Choices of law", "the rest of this page is for &lt;linear&gt;", "0.973", "not known",
        "0.055, 0.02 to 0.1", "law = &lt;linear&gt; (probability 0.97); a = 0.05"})
    EXPECT_THAT(html, HasSubstr(part)) << part;
}

TEST_F(StudyPage, HasNoPlotOfTheSensitivityToItsOnlyParameter) {
  test::Json j = test::Json::parse(kResults);
  j["parameters"].erase(1);
  j["estimate_history"] = test::Json::array();
  j["valley"] = test::Json::array();
  j["sensitivity"][0]["parameters"].erase("b");
  const std::string html = study_page(read_results_json(file(j.dump()))).html();
  EXPECT_THAT(html, HasSubstr("The study has one parameter, a:"));
  EXPECT_THAT(html, Not(HasSubstr("Sobol")));
  j["sensitivity"] = test::Json::array();
  EXPECT_THAT(study_page(read_results_json(file(j.dump()))).html(),
              Not(HasSubstr("has one parameter")));
}

// Results of earlier versions have none of these.
TEST_F(StudyPage, NeedsNoPredictionsOrHistory) {
  test::Json j = test::Json::parse(kResults);
  j["targets"][0].erase("posterior_predictive");
  j.erase("estimate_history");
  test::Json& sensitivity = j["sensitivity"][0]["parameters"]["a"];
  for (const char* key : {"first_interval_95", "total", "total_interval_95"})
    sensitivity.erase(key);
  const std::string html = study_page(read_results_json(file(j.dump()))).html();
  for (const char* part : {"Predicted responses", "Estimate by number of runs", "total Sobol"})
    EXPECT_THAT(html, Not(HasSubstr(part))) << part;
  EXPECT_THAT(html, HasSubstr("angle by a: 0.4. angle by b: 0.6."));
  j["estimate_history"] = test::Json::array();
  EXPECT_THAT(study_page(read_results_json(file(j.dump()))).html(),
              Not(HasSubstr("Estimate by number of runs")));
}

TEST_F(StudyPage, RefusesDamagedPredictionsHistoryAndIntervals) {
  const std::string predicted = "/targets/0/posterior_predictive", round = "/estimate_history/1",
                    a = "/sensitivity/0/parameters/a";
  const std::vector<std::pair<std::string, std::string>> replacements = {
      {predicted, "null"},
      {predicted, "[]"},
      {predicted + "/mean_response", "3"},
      {predicted + "/mean_response/quantiles", "[1, 2, 3, 4]"},
      {predicted + "/mean_response/quantiles", "[1, 2, 3, 4, null]"},
      {predicted + "/mean_response/quantiles", "[1, 2, 3, 5, 4]"},
      {predicted + "/mean_response/quantiles", "[1, 2, 3, 4, 1e300]"},
      {predicted + "/mean_response/quantiles", "\"text\""},
      {predicted + "/single_run/histogram/edges", "[5, 10]"},
      {predicted + "/single_run/histogram/edges", "[5, 5, 15]"},
      {predicted + "/single_run/histogram/edges", "[5, 10, null]"},
      {predicted + "/single_run/histogram/probability", "[0.5, -0.5]"},
      {predicted + "/single_run/histogram/probability", "[0.5, null]"},
      {predicted + "/single_run/histogram/probability", "{}"},
      {"/targets/0/uncertainty", "null"},
      {"/estimate_history", "{}"},
      {"/estimate_history", "null"},
      {round, "7"},
      {round + "/after", "7"},
      {round + "/runs", "-1"},
      {round + "/runs", "1.5"},
      {round + "/parameters", "[]"},
      {round + "/parameters/a/median", "null"},
      {round + "/parameters/a/median", "\"0.1\""},
      {round + "/parameters/a/interval_68", "[0.1]"},
      {round + "/parameters/a/interval_68", "[0.2, 0.1]"},
      {round + "/parameters/a/interval_95", "[null, 0.1]"},
      {a + "/first_interval_95", "[0.1, null]"},
      {a + "/first_interval_95", "[0.1, 0.2, 0.3]"},
      {a + "/total_interval_95", "\"0.1\""},
      {a + "/total", "\"0.1\""},
  };
  for (const auto& [where, value] : replacements) {
    test::Json j = test::Json::parse(kResults);
    j.at(test::Json::json_pointer(where)) = test::Json::parse(value);
    const std::string said = test::error_of([&] { study_page(read_results_json(file(j.dump()))); });
    EXPECT_EQ(said.find('\n'), said.npos) << said;
    EXPECT_THAT(said, HasSubstr("expected")) << where << " = " << value;
  }
}

TEST_F(StudyPage, SaysTheVerdictOnce) {
  std::string text = kResults;
  text.replace(text.find("a valley"), 8, "not identifiable: b is 0.2 +- 0.1");
  const std::string html = study_page(read_results_json(file(text))).html();
  EXPECT_THAT(html, HasSubstr("not identifiable</span> b is 0.2 ± 0.1<"));
}

TEST_F(StudyPage, RefusesWhatIsNoResult) {
  EXPECT_THROW(study_page(read_results_json(path("none.json"))), InputError);
  EXPECT_THROW(study_page(read_results_json(file("{"))), InputError);
  EXPECT_THROW(study_page(read_results_json(file("{\"kind\": \"validation\"}"))), InputError);
  EXPECT_THROW(study_page(read_results_json(file("{\"study\": \"x\"}"))), InputError);
  EXPECT_THROW(study_page(read_results_json("/dev/zero")), InputError);
  EXPECT_THROW(study_page(read_results_json(file(std::string(1 << 20, '[')))), InputError);
  std::string keys = "{";
  for (int i = 0; i < 20000; ++i) keys += "\"k" + std::to_string(i) + "\":0,";
  EXPECT_THROW(study_page(read_results_json(file(keys + "\"study\":\"x\"}"))), InputError);
}

// What a study writes can be read, whatever became of its runs.
TEST_F(StudyPage, OfEveryVerdict) {
  struct Member {
    const char* name;
    FakeExperiment::Formula formula;
  };
  const auto angle = [](double of) {
    return [of](const FakeExperiment::Values& v, std::mt19937_64& random) {
      return finished({scalar("aor", of + 10 * v.at("a.mu1") + normal_deviate(random), "deg")});
    };
  };
  const Member members[] = {
      {"met", angle(9)},
      {"far", angle(90)},
      {"not a number", angle(std::nan(""))},
      {"failed",
       [](const FakeExperiment::Values&, std::mt19937_64&) {
         return JobResult{JobStatus::failed, "<runaway>", {}, 1};
       }},
      {"half failed",
       [&](const FakeExperiment::Values& v, std::mt19937_64& random) {
         if (v.at("a.mu1") < 0.06) return JobResult{JobStatus::timed_out, "slow", {}, 1};
         return angle(9)(v, random);
       }},
      {"arched", [](const FakeExperiment::Values&, std::mt19937_64&) {
         return JobResult{JobStatus::arched, "arched", {scalar("aor", 45, "deg")}, 1};
       }}};
  std::set<StudyVerdict> verdicts;
  for (const Member& m : members) {
    const Folder folder("page");
    FakeExperiment experiment(m.formula);
    const StudySummary s = run_study(
        folder.write("study.toml",
                     friction_study("[[targets]]\nresponse = \"aor\"\nvalue = \"10 deg\"\n"
                                    "uncertainty = \"1 deg\"\n[[compare]]\nname = \"c\"\n"
                                    "values = { mu1 = 0.1, mu2 = 0.2 }\n")),
        folder / "out", experiment);
    verdicts.insert(s.verdict);
    const std::string html = study_page(read_results_json(folder / "out/results.json")).html();
    EXPECT_THAT(html, Not(HasSubstr("nan"))) << m.name;
    if (std::string(m.name) != "failed") continue;
    EXPECT_EQ(s.verdict, StudyVerdict::too_few_runs);
    EXPECT_THAT(s.headline, HasSubstr("did not finish, the first because of: <runaway>"));
    EXPECT_THAT(html, HasSubstr("&lt;runaway&gt;"));
  }
  EXPECT_GE(verdicts.size(), 3u);
}

// Every value of another type, length or size: a page, or one line.
TEST_F(StudyPage, TakesOrRefusesWhatIsDamaged) {
  test::damage(test::Json::parse(kResults), 60,
               [&](const std::string& text) { study_page(read_results_json(file(text))); });
}

using StudyPageLong = StudyPage;
TEST_F(StudyPageLong, TakesOrRefusesAllThatIsDamaged) {
  test::damage(test::Json::parse(kResults), 0,
               [&](const std::string& text) { study_page(read_results_json(file(text))); });
}

// Only tables are wider than a phone, and they scroll by themselves. A long text does not make its
// row as tall as a page.
TEST_F(StudyPage, FitsAPhone) {
  if (!has_browser()) GTEST_SKIP() << "chromium is not installed: the page is not laid out";
  test::Json j = test::Json::parse(kResults);
  std::string source;
  while (source.size() < 600) source += "assumed from seven readings of a protractor; ";
  j["targets"][0]["source"] = source;
  j["parameters"][0]["keys"] = {"interactions.ice-plastic.static_friction",
                                "interactions.ice-plastic.dynamic_friction"};
  page::Page page = study_page(read_results_json(file(j.dump())));
  page.add_script(std::string("addEventListener('load', () => {") + test::set_phone_width +
                  "; const outside = " + test::outside_of_phone + R"(;
    const heights = [...document.querySelectorAll('tr')].map((r) => r.getBoundingClientRect().height);
    document.body.dataset.outside = outside.map((e) => e.outerHTML.slice(0, 80)).join();
    document.body.dataset.tall = heights.some((h) => h > 450) ? Math.max(...heights) : 'none';
  });)");
  std::ofstream(path("page.html")) << page.html();
  const std::string dom = document_of(path("page.html"), "", "500,900");
  EXPECT_THAT(dom, HasSubstr("data-outside=\"\""));
  EXPECT_THAT(dom, HasSubstr("data-tall=\"none\""));
}

}  // namespace
}  // namespace firn
