// The bed in a drum, on beds of known slope; and the flow through a gate.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "experiments/analysis/line_fit.h"
#include "experiments/case_reader/read_case.h"
#include "tests/support/bench_run.h"

namespace firn {
namespace {

constexpr const char* kDrum = R"([case]
duration = "12 ms"
gravity = "0 0 0 m/s^2"
timestep = "20 us"
[materials.ice]
density = "916.7 kg/m^3"
young_modulus = "1 MPa"
[interactions.ice-ice]
static_friction = 0.1
restitution = 0.2
[shapes.cube]
kind = "box"
size = "10 10 10 mm"
material = "ice"
[[boundaries]]
name = "drum"
kind = "drum"
material = "ice"
diameter = "400 mm"
length = "20 mm"
[output]
frame_interval = "1 ms"
[[measure]]
kind = "drum"
boundary = "drum"
begin = "0 s"
)";

// Cubes in rows at rest, the uppermost `below` (m) under the axis, turned by `slope` (rad).
std::string bed(double slope, double below) {
  std::string text = kDrum;
  constexpr double kPitch = 10.2e-3, kRadius = 0.19;
  const double c = std::cos(slope), s = std::sin(slope);
  for (double v = -below - kPitch / 2; v > -kRadius; v -= kPitch) {
    for (int i = -20; i <= 20; ++i) {
      const double u = i * kPitch;
      if (std::hypot(u, v) > kRadius) continue;
      text += fmt::format(
          "[[particles]]\nshape = \"cube\"\nposition = \"0 {} {} m\"\n"
          "orientation = [{}, {}, 0, 0]\n",
          u * c - v * s, u * s + v * c, std::cos(slope / 2), std::sin(slope / 2));
    }
  }
  return text;
}

TEST(DrumResponses, FindTheSlopeOfAFlatBed) {
  for (const double degrees : {0.0, 12.0, 25.0, -35.0}) {
    const BenchRun r = run_case(read_case_text(bed(degrees * kDegToRad, 0.03), "drum.toml", "."));
    EXPECT_NEAR(r.value("drum_mass_angle"), std::abs(degrees), 1e-6);
    // Corners of cubes show, or not, within a column: up to a column's width in 200 mm.
    EXPECT_NEAR(r.value("drum_angle"), std::abs(degrees), 1.0) << degrees;
    EXPECT_NEAR(r.value("drum_angle_scatter"), 0, 1e-6);
    EXPECT_EQ(r["drum_angle"].unit, "deg");
  }
}

TEST(DrumResponses, AreUndefinedForFewerThanTenFrames) {
  const BenchRun r =
      run_case(read_case_text(bed(0, 0.03), "drum.toml", ".", {{"measure.0.begin", "4.5 ms"}}));
  for (const char* name : {"drum_angle", "drum_mass_angle", "drum_angle_scatter"}) {
    EXPECT_TRUE(std::isnan(r.value(name))) << name;
    EXPECT_TRUE(r[name].method.ends_with("undefined: 8 frames from 0.0045 s on, fewer than 10"))
        << r[name].method;
  }
}

// A run that was interrupted before the measure begins.
TEST(DrumResponses, AreUndefinedInAnInterruptedRun) {
  const test::ScratchFolder folder("interrupted_drum");
  std::atomic<bool> interrupt = false;
  int steps_left = 100;  // 2 ms of 12 ms
  RunOptions options;
  options.results_file = folder / "run.h5";
  options.interrupt = &interrupt;
  options.each_step = [&](const Solver&, bool) { interrupt = --steps_left < 0; };
  const Case c = read_case_text(bed(0, 0.03), "drum.toml", ".", {{"measure.0.begin", "5 ms"}});
  ASSERT_EQ(run(c, options).status, RunStatus::interrupted);
  const std::vector<Response> responses = measure(Recording(options.results_file));
  const auto angle = std::ranges::find(responses, "drum_angle", &Response::name);
  ASSERT_NE(angle, responses.end());
  EXPECT_TRUE(std::isnan(angle->value.at(0)));
  EXPECT_TRUE(angle->method.ends_with("undefined: 0 frames from 0.005 s on, fewer than 10"))
      << angle->method;
}

// Spheres move one behind the other, 10 ms apart. The mass flow is the mass of one over that time.
TEST(MassFlow, OfAStreamIsItsRate) {
  std::string text = R"([case]
duration = "0.6 s"
gravity = "0 0 0 m/s^2"
timestep = "20 us"
[materials.ice]
density = "1000 kg/m^3"
young_modulus = "1 MPa"
[interactions.ice-ice]
static_friction = 0.1
restitution = 0.2
[shapes.ball]
kind = "sphere"
radius = "2 mm"
mass = "5 g"
material = "ice"
[[particles]]
shape = "ball"
position = "0 0 10 mm"
velocity = "0 0 -1 m/s"
grid = [1, 1, 40]
spacing = "1 1 10 mm"
[[sensors]]
name = "slot"
point = "0 0 0 m"
normal = [0, 0, -1]
)";
  const BenchRun r = run_case(read_case_text(text, "flow.toml", "."));
  EXPECT_EQ(r.value("slot_count"), 40);
  EXPECT_NEAR(r.value("slot_mass_flow"), 0.005 / 0.010,
              0.01 * 0.5);  // gates are looked at now and then
  EXPECT_EQ(r["slot_mass_flow"].unit, "kg/s");
}

}  // namespace
}  // namespace firn
