#include "reports/documents/validation_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>

#include "experiments/case_reader/read_case.h"
#include "experiments/text/json_aliases.h"
#include "tests/reports/damaged_json.h"
#include "tests/support/results_folder.h"
#include "validation/validate.h"

namespace firn {
namespace {

using testing::HasSubstr;
using testing::Not;

JobResult finished(const std::vector<Response>& responses) {
  JobResult r;
  r.status = JobStatus::finished;
  r.responses = responses;
  return r;
}

// A validation of every kind, as its own functions make it of invented runs.
Validation example() {
  Validation v;
  v.suite.name = "example";
  v.suite.title = "Ice & <water>";
  v.suite.parameter_sets = {{"soft", "", "", {}, 0}, {"hard", "a note", "", {{"a.b", "1"}}, 0}};
  v.suite.experiments.push_back({"fall", "fall.toml", {}, {1, 2, 3}, {}});
  Measurement number;
  number.name = "height";
  number.value = 1;
  number.unit = "m";
  number.standard_deviation = 0.1;
  number.source = "a notebook";
  Measurement words;
  words.status = MeasurementStatus::qualitative;
  words.statement = "it falls";
  words.criteria = {{"it falls <far>", "height", "0.5", 1, 0, "because"},
                    {"it floats", "height", "5", 1, 0, "of no reason"}};
  MeasuredData counts;
  counts.present = true;
  counts.kind = MeasuredData::Kind::classes;
  counts.response = "counts";
  counts.classes = {"left", "right"};
  counts.counts = {3, 4};
  words.data = counts;
  Measurement strength;
  strength.unit = "N";
  strength.scatter = ScatterKind::range;
  strength.repeats = 7;
  strength.minimum = 898.5;
  strength.value = 1044;
  strength.maximum = 1227.7;
  using K = ComparisonKind;
  v.suite.comparisons = {
      {"h", "Height", "", K::value, 0, number, {"height"}, {}, true, 0},
      {"w", "Words", "", K::criteria, 0, words, {}, {}, true, 0},
      {"d", "Damage", "", K::breakage, 0, strength, {"compressive_loads"}, {}, true, 0},
      {"s", "Stiffness", "", K::stiffness_scaling, 0, {}, {"height"}, {}, true, 9.2e9},
      {"c", "Choices", "", K::numerical_variants, 0, {}, {"height"}, {}, true, 0}};
  for (std::size_t p = 0; p < 2; ++p) {
    RunGroup base{0, p, RunGroup::Purpose::base, 0, {1, 2, 3}, {"k1", "k2", "k3"}, {}};
    for (int i = 0; i < 3; ++i)
      base.results.push_back(finished({{"height", {1 + 0.1 * i}, {}, "m", "", 1},
                                       {"counts", {5.0 + i, 6}, {}, "1", "", 1},
                                       {"compressive_loads", {100, 900.0 + i}, {}, "N", "", 1}}));
    v.groups.push_back(base);
  }
  RunGroup stiff{0, 0, RunGroup::Purpose::stiffness, 1e8, {1}, {"k4"}, {}};
  stiff.results.push_back(finished({{"height", {2}, {}, "m", "", 1}}));
  v.groups.push_back(stiff);
  for (const SuiteComparison& what : v.suite.comparisons)
    for (std::size_t p = 0; p < 2; ++p) {
      ComparisonRuns e;
      e.base = &v.groups[p];
      e.numerics_base = &v.groups[0];
      e.stiffness = {&v.groups[2]};
      e.base_modulus = 1e7;
      v.comparisons.push_back(compare(v.suite, what, v.suite.parameter_sets[p], e));
    }
  v.command = "firn validate example.toml";
  return v;
}

class ValidationPage : public ResultsFolder {
 protected:
  std::string file(const std::string& text) const {
    std::ofstream(path("results.json")) << text;
    return path("results.json");
  }
};

TEST_F(ValidationPage, TakesOrRefusesWhatIsDamaged) {
  test::damage(test::Json::parse(render_json(example())), 60,
               [&](const std::string& text) { validation_page(read_results_json(file(text))); });
}
using ValidationPageLong = ValidationPage;
TEST_F(ValidationPageLong, TakesOrRefusesMuchThatIsDamaged) {
  test::damage(test::Json::parse(render_json(example())), 2000,
               [&](const std::string& text) { validation_page(read_results_json(file(text))); });
}

TEST_F(ValidationPage, HoldsEveryKindAndStandsAlone) {
  const std::string html = validation_page(read_results_json(file(render_json(example())))).html();
  EXPECT_THAT(html, HasSubstr("Ice &amp; &lt;water&gt;"));
  EXPECT_THAT(html, HasSubstr("it falls &lt;far&gt;"));
  EXPECT_THAT(html, Not(HasSubstr("<far>")));
  EXPECT_THAT(html, HasSubstr("weakest test"));
  EXPECT_THAT(html, HasSubstr("lines: weakest, mean and strongest breaking force"));
  EXPECT_THAT(html, HasSubstr(" 0 of 2 hold</td>"));  // three runs of one mind are too few
  EXPECT_THAT(html, HasSubstr("Grows as E"));
  EXPECT_THAT(html, HasSubstr("Young&#39;s modulus 0.1 GPa"));
  EXPECT_THAT(html, HasSubstr(": height / m"));  // a row of the plot of variants
  EXPECT_THAT(html, HasSubstr("firn validate example.toml"));
  EXPECT_THAT(html, HasSubstr("k4"));
  // Nothing is fetched: no address but the name of SVG's namespace.
  for (const char* link : {"src=\"http", "href=\"http", "url(http", "@import"})
    EXPECT_THAT(html, Not(HasSubstr(link)));
}

TEST_F(ValidationPage, CountsTheVerdictsThatOccur) {
  test::Json document = test::Json::parse(render_json(example()));
  const auto html_of = [&](const char* verdict, bool code_to_code) {
    for (test::Json& comparison : document["comparisons"]) {
      comparison["verdict"] = verdict;
      comparison["code_to_code"] = code_to_code;
    }
    return validation_page(read_results_json(file(document.dump()))).html();
  };
  for (const char* verdict : {"consistent", "inconsistent", "inconclusive", "not independent"}) {
    const std::string html = html_of(verdict, false);
    for (const std::string other :
         {"consistent", "inconsistent", "inconclusive", "not independent", "not comparable"}) {
      const std::string card = "<span class=\"label\">" + other + "</span>";
      EXPECT_EQ(html.find(card) != std::string::npos, other == verdict) << other;
    }
  }
  EXPECT_THAT(html_of("consistent", true), Not(HasSubstr("<ul class=\"cards\">")));
}

// The document with the names of earlier versions; children first, as their paths are current.
test::Json with_old_names(test::Json document) {
  const auto at = [&](std::string_view path, const auto& apply) {
    const auto step = [&](const auto& self, test::Json& node, std::string_view rest) -> void {
      if (rest.empty()) return apply(node);
      const std::size_t end = std::min(rest.find('.'), rest.size());
      std::string key(rest.substr(0, end));
      const std::string_view below = rest.substr(std::min(end + 1, rest.size()));
      const bool is_list = key.ends_with("[]");
      if (is_list) key.resize(key.size() - 2);
      if (!node.contains(key)) return;
      if (!is_list) return self(self, node[key], below);
      for (test::Json& element : node[key]) self(self, element, below);
    };
    step(step, document, path);
  };
  for (const JsonAlias& w : renamed_json_words()) {
    if (w.document != "validation") continue;
    at(w.path, [&](test::Json& object) {
      const std::string key(w.key);
      if (object.contains(key) && object[key] == std::string(w.name))
        object[key] = std::string(w.old_name);
    });
  }
  for (std::size_t i = renamed_json_keys().size(); i-- > 0;) {
    const JsonAlias& k = renamed_json_keys()[i];
    if (k.document != "validation") continue;
    at(k.path, [&](test::Json& object) {
      const std::string name(k.name);
      if (!object.contains(name)) return;
      object[std::string(k.old_name)] = object[name];
      object.erase(name);
    });
  }
  return document;
}

TEST_F(ValidationPage, IsTheSameFromAnEarlierFile) {
  const test::Json now = test::Json::parse(render_json(example()));
  const test::Json old = with_old_names(now);
  const std::string text = old.dump();
  for (const char* name : {"\"would_decide\"", "\"parts\"", "\"how\"", "\"claims\"", "\"larger\"",
                           "\"without_assumption\"", "\"softening\"", "\"word\"", "\"choice\""})
    EXPECT_THAT(text, HasSubstr(name));
  // Plots are numbered through all pages of a process.
  const auto page_from_text = [&](const std::string& results) {
    return std::regex_replace(validation_page(read_results_json(file(results))).html(),
                              std::regex("plot[0-9]+-"), "plot-");
  };
  EXPECT_EQ(page_from_text(text), page_from_text(now.dump()));
}

TEST_F(ValidationPage, SaysOnceWhatHoldsOfSeveralParameterSets) {
  Validation v = example();
  v.comparisons[0].caveats = {"the bin was wet", "one run failed"};
  v.comparisons[1].caveats = {"the bin was wet"};
  const std::string html = validation_page(read_results_json(file(render_json(v)))).html();
  EXPECT_THAT(html, HasSubstr("<li>the bin was wet</li>"));
  EXPECT_THAT(html, HasSubstr("<li>soft: one run failed</li>"));
  EXPECT_THAT(html, Not(HasSubstr("hard: the bin")));
}

constexpr const char* kFallSuite = R"(
[case]
name = "fall"
duration = "0.05 s"
timestep = "1e-4 s"
[materials.ice]
density = "1000 kg/m^3"
young_modulus = "0.01 GPa"
[interactions.ice-ice]
static_friction = 0.1
restitution = 0.3
[shapes.cube]
kind = "box"
size = "0.1 0.1 0.1 m"
material = "ice"
[[particles]]
shape = "cube"
position = "0 0 0.7 m"
[output]
frame_interval = "10 ms"
)";

std::size_t times(const std::string& text, const std::string& word) {
  std::size_t n = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++n;
  return n;
}

// Four comparisons of one experiment; the folder has been moved since.
TEST_F(ValidationPage, CarriesOneReplayOfAnExperiment) {
  std::filesystem::create_directories(path("runs"));
  run(read_case_text(kFallSuite, "fall.toml", "."), options("runs/k1.h5"));
  Validation v = example();
  v.groups[0].results[0].results_file = "/elsewhere/runs/k1.h5";
  const std::string results = file(render_json(v)),
                    html = validation_page(read_results_json(results)).html();
  EXPECT_EQ(times(html, "id=\"replay-fall\""), 1U);
  EXPECT_EQ(times(html, "id=\"replay-data-fall\""), 1U);
  EXPECT_EQ(times(html, "const FirnReplayData"), 1U);
  EXPECT_THAT(html, HasSubstr("results file k1.h5, parameter set soft, seed 1"));
  EXPECT_EQ(times(html, "<a href=\"#h\">above</a>"), 4U);  // of the comparisons behind the first
  const std::string without =
      validation_page(read_results_json(results), {.replays = false}).html();
  EXPECT_THAT(without, Not(HasSubstr("FirnReplay")));
  EXPECT_THAT(without, Not(HasSubstr("Watch it")));
}

TEST_F(ValidationPage, SaysWhyThereIsNoReplay) {
  std::filesystem::create_directories(path("runs"));
  std::ofstream(path("runs/k1.h5")) << "no results";
  Validation v = example();
  v.groups[0].results[0].results_file = path("runs/k1.h5");
  EXPECT_THAT(validation_page(read_results_json(file(render_json(v)))).html(),
              HasSubstr("no replay"));
}

TEST_F(ValidationPage, RefusesWhatIsNoResult) {
  EXPECT_THROW(validation_page(read_results_json(path("none.json"))), InputError);
  EXPECT_THROW(validation_page(read_results_json(file("{"))), InputError);
  EXPECT_THROW(validation_page(read_results_json(file("{\"kind\": \"study\"}"))), InputError);
  EXPECT_THROW(validation_page(read_results_json(file("[1]"))), InputError);
  EXPECT_THROW(validation_page(read_results_json(file("{\"kind\": \"validation\", \"title\": 3}"))),
               InputError);
}

}  // namespace
}  // namespace firn
