#include "experiments/responses/accelerometer_responses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "experiments/analysis/channel_filter.h"
#include "experiments/case_reader/read_case.h"
#include "tests/support/error_of.h"
#include "tests/support/results_folder.h"

namespace firn {
namespace {

using std::numbers::pi;
using testing::HasSubstr;

// Amplitude of a sine of that frequency behind the filter.
double gain(double frequency, double cfc) {
  const double interval = 1e-5;
  std::vector<double> x(20000);
  for (std::size_t i = 0; i < x.size(); ++i)
    x[i] = std::sin(2 * pi * frequency * interval * static_cast<double>(i));
  const std::vector<double> y = channel_filter(x, interval, cfc);
  double most = 0;
  for (std::size_t i = x.size() / 4; i < x.size() * 3 / 4; ++i) most = std::max(most, y[i]);
  return most;
}

TEST(ChannelFilter, HasTheGainsOfItsClass) {
  for (const double cfc : {180.0, 600.0, 1000.0}) {
    EXPECT_NEAR(gain(0.1 * cfc, cfc), 1, 0.002);
    EXPECT_NEAR(20 * std::log10(gain(1.65 * cfc, cfc)), -3, 0.2);
    EXPECT_LT(20 * std::log10(gain(10 * cfc, cfc)), -30);
  }
}

TEST(ChannelFilter, DelaysNothingAndKeepsWhatIsSteady) {
  std::vector<double> pulse(401, 0.0);
  pulse[200] = 1;
  const std::vector<double> y = channel_filter(pulse, 1e-4, 600);
  for (std::size_t i = 1; i < 150; ++i) EXPECT_NEAR(y[200 - i], y[200 + i], 1e-6) << i;
  for (double v : channel_filter(std::vector<double>(50, 3.5), 1e-4, 180))
    EXPECT_NEAR(v, 3.5, 1e-12);
  EXPECT_TRUE(channel_filter({}, 1e-4, 180).empty());
}

// A part on a spring that is let go 2 mm off its rest: its greatest acceleration is k x / m.
constexpr const char* kSpring = R"(
[case]
duration = "0.2 s"
gravity = "0 0 0 m/s^2"
timestep = "20 us"
[materials.ice]
density = "916.7 kg/m^3"
young_modulus = "1 MPa"
[shapes.cube]
kind = "box"
size = "20 20 20 mm"
material = "ice"
[[particles]]
shape = "cube"
position = "0 0 1 m"
[[motion_frames]]
name = "cup"
[motion_frames.free]
mass = "0.3 kg"
center = "0 0 0 m"
inertia = "1e-3 1e-3 1e-3 kg m^2"
[[motion_frames.free.joints]]
kind = "translation"
direction = [0, 0, 1]
stiffness = "3000 N/m"
spring_reference = "2 mm"
[[measure]]
kind = "accelerometer"
name = "cup"
motion_frame = "cup"
cfc = "600 Hz"
[output]
frame_interval = "0.1 ms"
)";

using Accelerometer = ResultsFolder;

TEST_F(Accelerometer, ReadsTheSpringsAcceleration) {
  const RunSummary summary = run(read_case_text(kSpring, "spring.toml", "."), options("run.h5"));
  ASSERT_EQ(summary.status, RunStatus::finished) << summary.reason;
  const auto value = [&](const std::string& name) {
    for (const Response& r : summary.responses)
      if (r.name == name) return r.value.at(0);
    return std::nan("");
  };
  EXPECT_NEAR(value("cup_acceleration_peak"), 3000 * 2e-3 / 0.3, 0.02);
  EXPECT_NEAR(value("cup_particle_mass_times_acceleration"),
              916.7 * 8e-6 * value("cup_acceleration_peak"), 1e-9);
  EXPECT_EQ(value("cup_contact_force_peak"), 0);
}

// Frames are whole steps apart: the filter goes by these, not by the interval that was asked for.
TEST_F(Accelerometer, FiltersByTheIntervalsOfTheFrames) {
  std::vector<double> peaks;
  for (const char* interval : {"0.1 ms", "0.109 ms", "0.091 ms"}) {
    const RunSummary summary =
        run(read_case_text(kSpring, "spring.toml", ".",
                           {{"output.frame_interval", interval}, {"measure.0.cfc", "60 Hz"}}),
            options("run.h5"));
    const auto peak =
        std::ranges::find(summary.responses, "cup_acceleration_peak", &Response::name);
    ASSERT_NE(peak, summary.responses.end());
    peaks.push_back(peak->value.at(0));
  }
  EXPECT_EQ(peaks[1], peaks[0]);
  EXPECT_EQ(peaks[2], peaks[0]);
}

TEST_F(Accelerometer, NeedsFramesAndAPartThatMoves) {
  const auto complaint = [](const Override& set) {
    return test::error_of([&] { read_case_text(kSpring, "spring.toml", ".", {set}); });
  };
  EXPECT_THAT(complaint({"output.frame_interval", "1 ms"}),
              HasSubstr("needs a sample every 0.167 ms, and frames are 1 ms apart"));
  EXPECT_THAT(complaint({"measure.0.axis", "1"}), HasSubstr("is no translation"));
}

}  // namespace
}  // namespace firn
