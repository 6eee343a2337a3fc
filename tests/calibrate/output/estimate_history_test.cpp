// The estimate after each round of runs, and predicted responses, as results.json has them.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/support/fake_experiment.h"

namespace firn {
namespace {

using nlohmann::json;

JobResult noisy_heap(const FakeExperiment::Values& v, std::mt19937_64& random) {
  return finished({scalar("aor", zhou_angle(v) + normal_deviate(random), "deg")});
}

json study_results(const std::string& text) {
  const Folder folder("history");
  FakeExperiment experiment(noisy_heap);
  return json::parse(run_study(folder.write("study.toml", text), folder / "out", experiment).json);
}

TEST(EstimateHistory, EndsInTheAnswer) {
  const json j = study_results(
      friction_study(angle_target + "[[numerics]]\nname = \"n\"\nset = { x = 1 }\n",
                     "center_replicates = 3\ndesign_points = 8\nreplicates_per_point = 2\n"
                     "refine_rounds = 2\nrefine_points = 3\nconfirmation_replicates = 5\n"));
  const json& history = j["estimate_history"];
  ASSERT_EQ(history.size(), 4u);
  const std::vector<std::string> rounds = {"design", "refinement 1", "refinement 2",
                                           "confirmation"};
  // Three at the middle, two with other numerics, 16 of the design; then 6, 6 and 5.
  const std::vector<int> runs = {21, 27, 33, 38};
  for (std::size_t i = 0; i < history.size(); ++i) {
    EXPECT_EQ(history[i]["after"], rounds[i]);
    EXPECT_EQ(history[i]["runs"], runs[i]);
    for (const json& p : history[i]["parameters"]) {
      EXPECT_LE(p["interval_95"][0], p["interval_68"][0]);
      EXPECT_LT(p["interval_68"][0], p["median"]);
      EXPECT_LT(p["median"], p["interval_68"][1]);
      EXPECT_LE(p["interval_68"][1], p["interval_95"][1]);
    }
  }
  EXPECT_EQ(history.back()["runs"], j["runs"]["total"]);
  for (const json& p : j["parameters"]) {
    const json& last = history.back()["parameters"][p["name"].get<std::string>()];
    for (const char* key : {"median", "interval_68", "interval_95"}) EXPECT_EQ(last[key], p[key]);
  }
  // Earlier entries are not copies of the answer.
  EXPECT_NE(history[0]["parameters"], history.back()["parameters"]);
}

// Runs its jobs in another order, as parallel processes end.
class ShuffledExperiment : public FakeExperiment {
 public:
  ShuffledExperiment(Formula formula, unsigned seed)
      : FakeExperiment(std::move(formula)), random_(seed) {}
  void run(const std::vector<Job>& jobs, const JobEvents& events) override {
    std::vector<Job> shuffled = jobs;
    std::ranges::shuffle(shuffled, random_);
    FakeExperiment::run(shuffled, events);
  }

 private:
  std::mt19937_64 random_;
};

TEST(EstimateHistory, IsTheSameInAnyOrderOfRunsAndAfterInterruptions) {
  const Folder folder("order");
  const std::string study = folder.write("study.toml", friction_study(angle_target));
  FakeExperiment whole(noisy_heap);
  const json expected = json::parse(run_study(study, folder / "whole", whole).json);
  ASSERT_GE(expected["estimate_history"].size(), 2u);
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const std::string out = folder / fmt::format("out{}", seed);
    // Interrupted after the design and within the refinement, each time in another order.
    for (const int runs : {7, 15, 3}) {
      ShuffledExperiment part(noisy_heap, seed);
      std::atomic<bool> interrupt = false;
      part.on_run = [&](const Job&) { interrupt = part.stop = part.runs == runs; };
      StudyOptions options;
      options.study_file = study;
      options.directory = out;
      options.show_progress = options.plot = false;
      options.interrupt = &interrupt;
      options.replace_executor = &part;
      calibrate(options);
    }
    ShuffledExperiment rest(noisy_heap, seed);
    const json j = json::parse(run_study(study, out, rest).json);
    EXPECT_EQ(j["estimate_history"], expected["estimate_history"]);
    EXPECT_EQ(j["targets"], expected["targets"]);
  }
}

TEST(EstimateHistory, IsEmptyWithoutAnEstimate) {
  const Folder folder("failing");
  FakeExperiment experiment([](const FakeExperiment::Values&, std::mt19937_64&) {
    return JobResult{JobStatus::failed, "no", {}, 1};
  });
  const json j = json::parse(run_study(folder.write("study.toml", friction_study(angle_target)),
                                       folder / "out", experiment)
                                 .json);
  EXPECT_TRUE(j["estimate_history"].empty());
  EXPECT_FALSE(j["targets"][0].contains("posterior_predictive"));
}

TEST(PredictedTargets, AreInTheResults) {
  const json predicted =
      study_results(friction_study(angle_target))["targets"][0]["posterior_predictive"];
  EXPECT_EQ(predicted["probabilities"], json::parse("[0.025, 0.16, 0.5, 0.84, 0.975]"));
  for (const char* name : {"mean_response", "single_run"}) {
    const std::vector<double> quantiles = predicted[name]["quantiles"];
    ASSERT_EQ(quantiles.size(), 5u);
    EXPECT_TRUE(std::ranges::is_sorted(quantiles));
    EXPECT_NEAR(quantiles[2], 10, 0.5);
    const json& histogram = predicted[name]["histogram"];
    EXPECT_EQ(histogram["edges"].size(), histogram["probability"].size() + 1);
  }
  // The runs scatter by 1 deg: twice the uncertainty of the measurement.
  const auto width = [&](const char* name) {
    const json& q = predicted[name]["quantiles"];
    return (q[3].get<double>() - q[1].get<double>()) / 2;
  };
  EXPECT_LT(width("mean_response"), 0.8);
  EXPECT_NEAR(width("single_run"), std::hypot(1, 0.6), 0.35);
}

}  // namespace
}  // namespace firn
