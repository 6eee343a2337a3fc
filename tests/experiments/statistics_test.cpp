// Statistics of contacts in cases and results files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "experiments/run.h"
#include "experiments/statistics_tables.h"
#include "tests/experiments/tray.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

std::string refusal(const std::vector<Override>& overrides) {
  try {
    tray(overrides);
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

TEST(StatisticsCase, ReadsWhatIsAskedFor) {
  const StatisticsOptions asked =
      tray({{"statistics.events.threshold", "\"2.5 N\""}, {"statistics.events.merge", "\"1 ms\""}})
          .model.statistics;
  EXPECT_TRUE(asked.events);
  EXPECT_EQ(asked.threshold, 2.5);
  EXPECT_EQ(asked.merge, 1e-3);
}

TEST(StatisticsCase, RefusesWhatMakesNoSense) {
  EXPECT_THAT(refusal({{"statistics.events.threshold", "\"-1 N\""}}),
              HasSubstr("statistics.events.threshold: "));
  EXPECT_THAT(refusal({{"statistics.events.threshold", "\"1 J\""}}),
              HasSubstr("statistics.events.threshold: "));
  EXPECT_THAT(refusal({{"statistics.events.merge", "3"}}), HasSubstr("statistics.events.merge: "));
  EXPECT_THAT(refusal({{"statistics.events.treshold", "\"1 N\""}}), HasSubstr("threshold"));
}

class StatisticsFile : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    directory_ = fs::temp_directory_path() /
                 ("firn-" + std::string(test->name()) + "-" + std::to_string(::getpid()));
    fs::create_directories(directory_);
  }
  void TearDown() override { fs::remove_all(directory_); }
  Recording recorded(const Case& c) {
    RunOptions options;
    options.results_file = (directory_ / "run.h5").string();
    const RunSummary summary = run(c, options);
    EXPECT_EQ(summary.status, RunStatus::finished) << summary.reason;
    return Recording(options.results_file);
  }

  fs::path directory_;
};

// What the file says of contacts is what boundaries and particles say of themselves.
TEST_F(StatisticsFile, HoldsEveryContactAboveTheThreshold) {
  const Case c =
      tray({{"statistics.events.threshold", "\"0.2 N\""}, {"case.duration", "\"0.2 s\""}});
  const Recording recording = recorded(c);
  const std::vector<ContactEvent> events = contact_events(recording);
  ASSERT_GT(events.size(), 13u);
  const std::vector<double> peaks = recording.peak_normal_force();
  std::vector<double> largest(peaks.size(), 0);
  double first = 1;
  for (const ContactEvent& e : events) {
    EXPECT_GE(e.peak_normal_force, 0.2);
    EXPECT_LT(e.a, e.b);
    largest.at(e.a) = std::max(largest[e.a], e.peak_normal_force);
    if (e.b < 13) largest[e.b] = std::max(largest[e.b], e.peak_normal_force);
    first = std::min(first, e.start);
    if (e.b >= 13) {  // on the floor: in its axes the top is half of its thickness up
      EXPECT_EQ(e.b, 13);
      EXPECT_NEAR(e.place_on_b.z(), 0.05, 1e-3);
      EXPECT_NEAR(e.place.z(), 0, 1e-3);
    }
    // On the surface of a cube of 20 mm, but for what it is pressed in.
    EXPECT_NEAR(e.place_on_a.lpNorm<Eigen::Infinity>(), 0.01, 1e-3);
  }
  // Cubes have one patch with each other: the largest of a particle's contacts is its peak.
  for (std::size_t i = 0; i < peaks.size(); ++i) EXPECT_NEAR(largest[i], peaks[i], 1e-9) << i;
  EXPECT_GT(first, 0);
  EXPECT_TRUE(events.back().lasts);
  EXPECT_FALSE(events.front().lasts);
}

}  // namespace
}  // namespace firn
