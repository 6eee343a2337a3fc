#include "experiments/run/sampler.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include "experiments/case_reader/read_case.h"
#include "experiments/export/export.h"
#include "tests/support/error_of.h"
#include "tests/support/results_folder.h"

namespace firn {
namespace {

using testing::HasSubstr;

// Twelve cubes fall on a tray that a spring holds in tilted guides.
constexpr const char* kTray = R"(
[case]
duration = "0.15 s"
[materials.ice]
density = "916.7 kg/m^3"
young_modulus = "1 MPa"
[interactions.ice-ice]
restitution = 0.3
static_friction = 0.2
dynamic_friction = 0.2
[shapes.cube]
kind = "box"
size = "20 20 20 mm"
material = "ice"
[[fills]]
shape = "cube"
count = 12
region_min = "-40 -30 20 mm"
region_max = "40 30 120 mm"
[[motion_frames]]
name = "cup"
[motion_frames.free]
mass = "0.3 kg"
center = "0 0 0 m"
inertia = "1e-3 1e-3 1e-3 kg m^2"
[[motion_frames.free.joints]]
kind = "translation"
direction = [0, 0.1, 1]
stiffness = "2e4 N/m"
damping = "10 N s/m"
[[boundaries]]
name = "tray"
kind = "box"
size = "0.2 0.2 0.02 m"
material = "ice"
motion_frame = "cup"
[[boundaries]]
name = "ground"
kind = "plane"
point = "0 0 -0.02 m"
normal = [0, 0, 1]
material = "ice"
[[stages]]
name = "fall"
max_duration = "0.06 s"
[[stages]]
name = "rest"
max_duration = "1 s"
[[measure]]
kind = "accelerometer"
name = "cup"
motion_frame = "cup"
cfc = "180 Hz"
[[measure]]
kind = "curve"
name = "pull"
motion_frame = "cup"
x = "coordinate"
y = "reaction_force"
points = 20000
[[measure]]
kind = "load"
name = "tray"
boundary = "tray"
stage = "rest"
[output]
frame_interval = "0.4 ms"
)";

Case tray(const std::vector<Override>& set) { return read_case_text(kTray, "tray.toml", ".", set); }

const std::vector<Override> kAllSampled = {{"output.samples.motion_frames", "[\"cup\"]"},
                                           {"output.samples.boundaries", "[\"tray\", \"ground\"]"}};

class Samples : public ResultsFolder {
 protected:
  // The results of the case with these values, with all parts sampled if there is an interval.
  Recording recording(std::vector<Override> set, const std::string& interval) {
    if (!interval.empty()) {
      set.push_back({"output.samples.interval", interval});
      set.insert(set.end(), kAllSampled.begin(), kAllSampled.end());
    }
    const std::string name = fmt::format("{}.h5", ++count_);
    last_ = run(tray(set), options(name));
    EXPECT_EQ(last_.status, RunStatus::finished) << last_.reason;
    return Recording(path(name));
  }
  double value(const std::string& name) const {
    for (const Response& r : last_.responses)
      if (r.name == name) return r.value.at(0);
    return std::nan("");
  }

  RunSummary last_;
  int count_ = 0;
};

// Sum of the loads of all rows, each times the interval that it ends.
Vec3 impulse(const std::vector<double>& times, const std::vector<double>& rows) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 1; k < times.size(); ++k)
    sum += (times[k] - times[k - 1]) * Vec3(rows[3 * k], rows[3 * k + 1], rows[3 * k + 2]);
  return sum;
}

constexpr const char* kLoads[] = {"boundaries/tray/force",
                                  "boundaries/tray/torque",
                                  "motion_frames/cup/force",
                                  "motion_frames/cup/torque",
                                  "motion_frames/cup/reaction_force",
                                  "motion_frames/cup/reaction_torque"};

// Frames of the same intervals are the second method.
TEST_F(Samples, AreWhatFramesOfTheirIntervalHave) {
  const Recording sampled = recording({{"output.frame_interval", "7 ms"}}, "0.4 ms");
  const Recording frames = recording({}, "");
  const std::vector<double> times = sampled.values("/samples/time"), all = frames.frame_times();
  ASSERT_GE(times.size(), 370U);
  for (std::size_t k = 0; k < times.size(); ++k) ASSERT_EQ(times[k], all[k]);
  for (const char* name : {"coordinate", "rate"}) {
    const std::string path = fmt::format("motion_frames/cup/{}", name);
    const std::vector<double> samples = sampled.values("/samples/" + path),
                              series = frames.series("/" + path);
    for (std::size_t k = 0; k < times.size(); ++k) ASSERT_EQ(samples[k], series[k]) << path;
  }
  for (const char* path : kLoads) {
    const std::vector<double> samples = sampled.values(fmt::format("/samples/{}", path)),
                              series = frames.series(fmt::format("/{}", path));
    double largest = 0;
    for (double v : series) largest = std::max(largest, std::abs(v));
    EXPECT_GT(largest, 0) << path;
    for (std::size_t k = 0; k < samples.size(); ++k)
      ASSERT_NEAR(samples[k], series[k], 1e-9 * largest) << path << ", value " << k;
  }
}

// Frames clear the loads, in the middle of a sample or at its end.
TEST_F(Samples, DoNotDependOnTheFrames) {
  std::mt19937 random(5);
  std::uniform_int_distribution<int> microseconds(100, 550);
  for (int trial = 0; trial < 4; ++trial) {
    const int sample = microseconds(random);
    const Recording reference =
        recording({{"output.frame_interval", "1 s"}}, fmt::format("{} us", sample));
    const std::vector<double> times = reference.values("/samples/time");
    for (std::size_t k = 1; k < times.size(); ++k)
      ASSERT_NEAR(times[k] - times[k - 1], times[1], 1e-12);
    const int frame = microseconds(random);
    SCOPED_TRACE(fmt::format("frames every {} us, samples every {} us", frame, sample));
    const Recording other = recording({{"output.frame_interval", fmt::format("{} us", frame)}},
                                      fmt::format("{} us", sample));
    ASSERT_EQ(other.values("/samples/time"), times);
    for (const char* path : kLoads) {
      const std::vector<double> a = reference.values(fmt::format("/samples/{}", path)),
                                b = other.values(fmt::format("/samples/{}", path));
      double largest = 0;
      for (double v : a) largest = std::max(largest, std::abs(v));
      for (std::size_t k = 0; k < a.size(); ++k)
        ASSERT_NEAR(a[k], b[k], 1e-8 * largest) << path << ", value " << k;
    }
  }
}

TEST_F(Samples, BeginWithTheirStage) {
  const Recording r = recording({{"output.samples.from_stage", "rest"}}, "0.4 ms");
  const double start = r.stages().at(1).start;
  const std::vector<double> times = r.values("/samples/time");
  ASSERT_FALSE(times.empty());
  EXPECT_EQ(times[0], start);
  // No impulse of the time before is in them: they have that of the frames since the stage began.
  const std::vector<double> rows = r.values("/samples/boundaries/tray/force"),
                            series = r.series("/boundaries/tray/force"), all = r.frame_times();
  Vec3 framed = Vec3::Zero(), before = Vec3::Zero();
  for (std::size_t k = 1; k < all.size(); ++k)
    (all[k] > start + 1e-9 ? framed : before) +=
        (all[k] - all[k - 1]) * Vec3(series[3 * k], series[3 * k + 1], series[3 * k + 2]);
  EXPECT_GT(std::abs(before.z()), 0.05 * std::abs(framed.z()));
  EXPECT_NEAR(impulse(times, rows).z(), framed.z(), 0.02 * std::abs(framed.z()));
}

TEST_F(Samples, MeasuresUseThem) {
  recording({}, "");
  const double acceleration = value("cup_acceleration_peak"),
               force = value("cup_contact_force_peak"), mean = value("tray_load_mean"),
               peak = value("tray_load_peak");
  ASSERT_GT(acceleration, 1);
  recording({{"output.frame_interval", "20 ms"}}, "0.4 ms");
  EXPECT_NEAR(value("cup_acceleration_peak"), acceleration, 1e-6 * acceleration);
  EXPECT_NEAR(value("cup_contact_force_peak"), force, 1e-6 * force);
  EXPECT_NEAR(value("tray_load_mean"), mean, 5e-3 * mean);
  EXPECT_NEAR(value("tray_load_peak"), peak, 1e-6 * peak);
  const auto curve = std::ranges::find(last_.responses, "pull_curve_y", &Response::name);
  ASSERT_NE(curve, last_.responses.end());
  EXPECT_GT(curve->value.size(), 300U);
}

// Samples of a later stage do not change what a load says of an earlier one, or of the run.
TEST_F(Samples, OfALaterStageLeaveLoadsToTheFrames) {
  for (const char* stage : {"\"fall\"", "\"\"", "\"rest\""}) {
    SCOPED_TRACE(stage);
    const Override measured{"measure.2.stage", stage};
    recording({measured}, "");
    const double mean = value("tray_load_mean"), peak = value("tray_load_peak");
    ASSERT_GT(mean, 0);
    recording({measured, {"output.samples.from_stage", "rest"}}, "0.1 ms");
    EXPECT_NEAR(value("tray_load_mean"), mean, 5e-3 * mean);
    if (std::string(stage) == "\"rest\"")
      EXPECT_GT(value("tray_load_peak"), peak);
    else
      EXPECT_EQ(value("tray_load_peak"), peak);
  }
}

TEST_F(Samples, OfAStageThatNeverBeginsAreNone) {
  const Recording r =
      recording({{"output.samples.from_stage", "rest"}, {"case.duration", "20 ms"}}, "0.4 ms");
  EXPECT_TRUE(r.values("/samples/time").empty());
  EXPECT_TRUE(r.values("/samples/motion_frames/cup/rate").empty());
  EXPECT_TRUE(std::isnan(value("cup_acceleration_peak")));
  export_csv(r, path("csv"));
}

TEST_F(Samples, AreExportedUnderTheNamesOfFrames) {
  const Recording r = recording({{"case.duration", "10 ms"}}, "0.4 ms");
  export_csv(r, path("csv"));
  std::ifstream csv(path("csv/samples.csv"));
  std::string header, line;
  std::getline(csv, header);
  EXPECT_THAT(header, testing::StartsWith("time [s],boundaries/tray/force.x [N],"));
  EXPECT_THAT(header, HasSubstr(",motion_frames/cup/rate [SI],"));
  std::size_t rows = 0;
  for (; std::getline(csv, line); ++rows)
    ASSERT_EQ(std::ranges::count(line, ','), std::ranges::count(header, ','));
  EXPECT_EQ(rows, r.values("/samples/time").size());
  export_csv(recording({{"case.duration", "10 ms"}}, ""), path("none"));
  EXPECT_FALSE(std::filesystem::exists(path("none/samples.csv")));
}

TEST_F(Samples, DoNotChangeTheMotion) {
  const Recording with = recording({}, "0.3 ms"), without = recording({}, "");
  EXPECT_EQ(with.series("/frames/position"), without.series("/frames/position"));
  EXPECT_EQ(with.series("/motion_frames/cup/force"), without.series("/motion_frames/cup/force"));
}

TEST(SamplesOfACase, AreRefusedWithALine) {
  const auto complaint = [](std::vector<Override> set) {
    return test::error_of([&] { tray(set); });
  };
  const Override interval{"output.samples.interval", "1 ms"},
      cup{"output.samples.motion_frames", "[\"cup\"]"};
  EXPECT_THAT(complaint({cup}), HasSubstr("output.samples.interval: missing"));
  EXPECT_THAT(complaint({interval}), HasSubstr("expected names of motion frames or boundaries"));
  EXPECT_THAT(complaint({interval, {"output.samples.motion_frames", "[\"cub\"]"}}),
              HasSubstr("output.samples.motion_frames: "));
  EXPECT_THAT(complaint({interval, {"output.samples.motion_frames", "[\"cup\", \"cup\"]"}}),
              HasSubstr("names \"cup\" twice"));
  EXPECT_THAT(complaint({interval, {"output.samples.boundaries", "[\"cup\"]"}}),
              HasSubstr("output.samples.boundaries: "));
  EXPECT_THAT(complaint({cup, {"output.samples.interval", "1e-9 s"}}),
              HasSubstr("shorter than the time step"));
  EXPECT_THAT(complaint({cup, interval, {"output.samples.from_stage", "later"}}),
              HasSubstr("\"later\" is no stage of the case; expected one of \"fall\", \"rest\""));
  EXPECT_THAT(complaint({cup, {"output.samples.interval", "2 ms"}}),
              HasSubstr("needs a sample every 0.556 ms, and samples are 2 ms apart; expected a "
                        "shorter output.samples.interval"));
  EXPECT_THAT(complaint({{"output.frame_interval", "2 ms"}}),
              HasSubstr("and frames are 2 ms apart; expected a shorter output.frame_interval, or "
                        "[output.samples]"));
}

}  // namespace
}  // namespace firn
