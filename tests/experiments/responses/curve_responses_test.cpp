#include "experiments/responses/curve_responses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "experiments/case_reader/read_case.h"
#include "tests/support/error_of.h"
#include "tests/support/results_folder.h"

namespace firn {
namespace {

using testing::HasSubstr;

// A cup on a spring that is let go 2 mm off its rest, and a block that a platen presses on a floor.
constexpr const char* kBench = R"(
[case]
duration = "0.2 s"
gravity = "0 0 0 m/s^2"
timestep = "20 us"
[materials.ice]
density = "916.7 kg/m^3"
young_modulus = "1 MPa"
[interactions.ice-ice]
static_friction = 0.1
restitution = 0.3
[shapes.cube]
kind = "box"
size = "20 20 20 mm"
material = "ice"
[[particles]]
shape = "cube"
position = "0 0 10 mm"
[[boundaries]]
name = "floor"
kind = "plane"
material = "ice"
normal = [0, 0, 1]
rigid = true
[[boundaries]]
name = "platen"
kind = "box"
material = "ice"
rigid = true
size = "40 40 10 mm"
position = "0 0 25.1 mm"
motions = [{ kind = "translation", velocity = "0 0 -5 mm/s" }]
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
kind = "curve"
name = "spring"
motion_frame = "cup"
x = "coordinate"
y = "acceleration"
[[measure]]
kind = "curve"
name = "swing"
motion_frame = "cup"
y = "coordinate"
x_period = "62.8318531 ms"
points = 10
[[measure]]
kind = "curve"
name = "press"
boundary = "platen"
x = "displacement"
y = "force"
points = 50
[[stages]]
name = "near"
max_duration = "0.1 s"
[[stages]]
name = "press"
max_duration = "0.1 s"
[[measure]]
kind = "load"
name = "all"
boundary = "platen"
[[measure]]
kind = "load"
name = "late"
boundary = "platen"
direction = [0, 0, 2]
stage = "press"
[output]
frame_interval = "0.2 ms"
)";

using Curves = ResultsFolder;

TEST_F(Curves, HaveTheSlopesOfTheirSprings) {
  const RunSummary summary = run(read_case_text(kBench, "bench.toml", "."), options("run.h5"));
  ASSERT_EQ(summary.status, RunStatus::finished) << summary.reason;
  const auto response = [&](const std::string& name) {
    const auto found = std::ranges::find(summary.responses, name, &Response::name);
    return found == summary.responses.end() ? Response{} : *found;
  };
  // a = k (rest - x) / m; rates of neighboring frames give it half a frame before.
  const Response x = response("spring_curve_x"), a = response("spring_curve_y");
  ASSERT_EQ(x.value.size(), 500U);
  ASSERT_EQ(a.value.size(), 500U);
  EXPECT_EQ(x.unit, "m");
  EXPECT_EQ(a.unit, "m/s^2");
  for (std::size_t i = 1; i < x.value.size(); i += 50)
    EXPECT_NEAR(a.value[i], 3000 * (2e-3 - x.value[i]) / 0.3, 0.25) << i;
  // The block's stiffness E L acts at both sides: half of it. It is touched after 0.1 mm.
  const Response way = response("press_curve_x"), force = response("press_curve_y");
  ASSERT_EQ(way.value.size(), 50U);
  EXPECT_NEAR(way.value.back(), 1e-3, 1e-6);
  EXPECT_EQ(force.value.front(), 0);
  EXPECT_NEAR(force.value.back(), 0.5 * 1e6 * 0.02 * 0.9e-3, 0.02 * 9);
  EXPECT_THAT(force.method, HasSubstr("force over displacement of \"platen\""));
}

// The cup's coordinate is 2 mm (1 - cos w t) with w = 100/s: three periods and a part of a fourth.
TEST_F(Curves, AreFoldedOverTheirPeriod) {
  const RunSummary summary = run(read_case_text(kBench, "bench.toml", "."), options("run.h5"));
  ASSERT_EQ(summary.status, RunStatus::finished) << summary.reason;
  const auto response = [&](const std::string& name) {
    const auto found = std::ranges::find(summary.responses, name, &Response::name);
    return found == summary.responses.end() ? Response{} : *found;
  };
  const Response x = response("swing_curve_x"), mean = response("swing_curve_y"),
                 least = response("swing_curve_y_min"), most = response("swing_curve_y_max");
  ASSERT_EQ(x.value.size(), 10U);
  ASSERT_EQ(mean.value.size(), 10U);
  ASSERT_EQ(least.value.size(), 10U);
  ASSERT_EQ(most.value.size(), 10U);
  EXPECT_EQ(x.unit, "s");
  EXPECT_EQ(most.unit, "m");
  EXPECT_THAT(mean.method, HasSubstr("folded with a period of 0.0628319 s, 10 bins: mean of each"));
  const auto coordinate = [](double phase) { return 2e-3 * (1 - std::cos(phase)); };
  for (std::size_t k = 0; k < 10; ++k) {
    const double low = 0.2 * std::numbers::pi * static_cast<double>(k),
                 high = low + 0.2 * std::numbers::pi;
    EXPECT_NEAR(x.value[k], 0.5e-2 * (low + high), 1e-9) << k;
    const double expected = 2e-3 * (1 - (std::sin(high) - std::sin(low)) / (high - low));
    EXPECT_NEAR(mean.value[k], expected, 6e-5) << k;
    const auto [from, to] = std::minmax({coordinate(low), coordinate(high)});
    EXPECT_NEAR(least.value[k], from, 6e-5) << k;
    EXPECT_NEAR(most.value[k], to, 6e-5) << k;
  }
}

TEST_F(Curves, HaveAPeriodInTheUnitsOfTheirX) {
  const auto period = [](const std::string& measure, const std::string& value) {
    const Case c = read_case_text(
        kBench, "bench.toml", ".",
        {{"motion_frames.cup.free.joints", "[{ kind = \"rotation\", direction = [0, 0, 1] }]"},
         {"measure." + measure + ".x_period", value}});
    return std::ranges::find(c.measures, measure, &Measure::name)->x_period;
  };
  EXPECT_DOUBLE_EQ(period("spring", "720 deg"), 4 * std::numbers::pi);
  EXPECT_DOUBLE_EQ(period("swing", "2 s"), 2);
  EXPECT_DOUBLE_EQ(period("press", "3 mm"), 3e-3);
}

// The platen touches after 0.02 s and comes 5 mm/s nearer: a force that grows with time.
TEST_F(Curves, LoadsAreMeansOverTheirStage) {
  const RunSummary summary = run(read_case_text(kBench, "bench.toml", "."), options("run.h5"));
  ASSERT_EQ(summary.status, RunStatus::finished) << summary.reason;
  const auto response = [&](const std::string& name) {
    return std::ranges::find(summary.responses, name, &Response::name)->value.at(0);
  };
  const double rate = 0.5 * 1e6 * 0.02 * 5e-3;  // N/s
  EXPECT_NEAR(response("late_load_mean"), rate * (0.15 - 0.02), 0.02 * rate * 0.13);
  EXPECT_NEAR(response("late_load_peak"), rate * (0.2 - 0.02), 0.02 * rate * 0.18);
  EXPECT_NEAR(response("all_load_mean"), rate * 0.18 * 0.18 / 2 / 0.2, 0.02 * rate * 0.081);
  EXPECT_EQ(response("all_load_peak"), response("late_load_peak"));
}

TEST_F(Curves, AreRefusedInOneLine) {
  const auto complaint = [](const std::string& key, const std::string& value) {
    return test::error_of([&] { read_case_text(kBench, "bench.toml", ".", {{key, value}}); });
  };
  EXPECT_THAT(complaint("measure.press.boundary", "nothing"), HasSubstr("nothing"));
  EXPECT_THAT(complaint("measure.press.motion_frame", "cup"), HasSubstr("expected one of them"));
  EXPECT_THAT(complaint("measure.press.y", "motor_load"), HasSubstr("motor_load"));
  EXPECT_THAT(complaint("measure.press.points", "1"), HasSubstr("points"));
  EXPECT_THAT(complaint("measure.spring.axis", "1"),
              HasSubstr("expected the index of a joint of a free motion frame"));
  EXPECT_THAT(complaint("measure.spring.cfc", "1000 Hz"), HasSubstr("needs a sample every"));
  for (const char* wrong : {"0 mm", "-1 mm", "720 deg", "2"})
    EXPECT_THAT(complaint("measure.spring.x_period", wrong), HasSubstr("measure.spring.x_period"));
  EXPECT_THAT(complaint("measure.late.x_period", "1 s"), HasSubstr("x_period"));
  EXPECT_THAT(complaint("measure.late.stage", "after"), HasSubstr("\"after\" is not a stage"));
  EXPECT_THAT(complaint("measure.late.motion_frame", "cup"), HasSubstr("expected one of them"));
  EXPECT_THAT(complaint("measure.late.direction", "[0, 0, 0]"), HasSubstr("direction"));
}

}  // namespace
}  // namespace firn
