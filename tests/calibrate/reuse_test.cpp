// Studies that continue from runs of other studies.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "experiments/analysis/random_stream.h"
#include "tests/calibrate/lab_study.h"

namespace firn {
namespace {

using namespace lab;
using nlohmann::json;

// A study with a store; how many runs it had to simulate.
struct Stored {
  explicit Stored(const std::string& name) : folder(name) {}
  json run(const std::string& name, const std::string& text, int& simulated) {
    FakeExperiment experiment([](const Values& v, std::mt19937_64& random) {
      const double a = v.at("a"), b = v.at("b");
      return finished({scalar("t0", 10 + 8 * a + 4 * a * b + 2 * normal_deviate(random), "1"),
                       scalar("t1", 10 + 8 * b + 2 * normal_deviate(random), "1")});
    });
    StudyOptions options;
    options.study_file = folder.write(name + ".toml", text);
    options.directory = folder / name;
    options.store = folder / "store.db";
    options.show_progress = options.plot = false;
    options.replace_executor = &experiment;
    const json j = json::parse(calibrate(options).json);
    simulated = experiment.runs;
    return j;
  }
  Folder folder;
};

TEST(Reuse, LargerBudgetsOtherRangesAndMoreTargetsGoOnFromWhatWasRun) {
  Stored stored("reuse");
  const std::vector<Aim> both = {{14, 0.5}, {14, 0.5}};
  int simulated = 0;
  const json first = stored.run("forty", study_text(unit_square, both, 40, 1), simulated);
  EXPECT_EQ(simulated, 40 - first["budget"]["left"].get<int>());
  const int forty = simulated;
  const json larger = stored.run("sixty", study_text(unit_square, both, 60, 1), simulated);
  EXPECT_LE(simulated, 60 - forty) << larger.dump(1);
  EXPECT_EQ(larger["runs"]["total"], forty + simulated);
  EXPECT_GT(larger["budget"]["reused"], 30);
  // The same again, in another folder: nothing is new, and the answer is the same.
  const json again = stored.run("again", study_text(unit_square, both, 60, 1), simulated);
  EXPECT_EQ(simulated, 0);
  EXPECT_EQ(again["estimate"], larger["estimate"]);
  // Going on in the folder of a study changes nothing either.
  EXPECT_EQ(stored.run("sixty", study_text(unit_square, both, 60, 1), simulated), larger);
  EXPECT_EQ(simulated, 0);
  const json narrower =
      stored.run("narrower", study_text({{"a", 0, 0.9}, {"b", 0, 1}}, both, 60, 1), simulated);
  EXPECT_LE(simulated, 20);
  const json wider =
      stored.run("wider", study_text({{"a", -0.2, 1}, {"b", 0, 1.1}}, both, 75, 1), simulated);
  EXPECT_LE(simulated, 25);
  // No reuse, where the study says so.
  std::string alone = study_text(unit_square, both, 41, 7);
  alone.insert(alone.find("runs = 41"), "reuse = false\n");
  EXPECT_EQ(stored.run("alone", alone, simulated)["budget"]["reused"], 0);
}

TEST(Reuse, AnotherTargetCostsNoRunThatWasMade) {
  Stored stored("target");
  int simulated = 0;
  stored.run("one", study_text(unit_square, {{14, 0.5}}, 40, 1), simulated);
  const json two =
      stored.run("two", study_text(unit_square, {{14, 0.5}, {14, 0.5}}, 44, 1), simulated);
  EXPECT_LE(simulated, 12);
  EXPECT_LE(two["runs"]["total"], 44);
}

}  // namespace
}  // namespace firn
