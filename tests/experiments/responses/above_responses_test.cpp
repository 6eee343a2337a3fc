#include "experiments/responses/above_responses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "experiments/case_reader/read_case.h"
#include "tests/support/bench_run.h"
#include "tests/support/error_of.h"

namespace firn {
namespace {

using testing::HasSubstr;

// A shelf that is fixed in space. Two balls lie on it. A third is clamped between it and a lift
// below, a fourth between its side and a stop: 0.1 mm of overlap at each contact, 1 N or more,
// which friction holds. A fifth lies on the floor. The lift goes after the first stage.
constexpr const char* kShelf = R"(
[case]
duration = "0.2 s"
[materials.ice]
density = "916.7 kg/m^3"
young_modulus = "1 MPa"
[interactions.ice-ice]
static_friction = 0.3
restitution = 0.3
[shapes.ball]
kind = "sphere"
radius = "10 mm"
material = "ice"
[[particles]]
shape = "ball"
position = "-30 0 15 mm"
[[particles]]
shape = "ball"
position = "20 0 15 mm"
[[particles]]
shape = "ball"
position = "0 0 -14.9 mm"
[[particles]]
shape = "ball"
position = "59.9 0 0 mm"
[[particles]]
shape = "ball"
position = "150 0 -90 mm"
[[boundaries]]
name = "floor"
kind = "plane"
material = "ice"
point = "0 0 -100 mm"
normal = [0, 0, 1]
[[boundaries]]
name = "shelf"
kind = "box"
material = "ice"
position = "0 0 0 mm"
size = "100 40 10 mm"
[[boundaries]]
name = "lift"
kind = "box"
material = "ice"
position = "0 0 -29.8 mm"
size = "40 40 10 mm"
[[boundaries]]
name = "stop"
kind = "box"
material = "ice"
position = "74.8 0 0 mm"
size = "10 40 10 mm"
[[stages]]
name = "hold"
max_duration = "0.1 s"
[[stages]]
name = "drop"
remove_boundaries = ["lift"]
max_duration = "0.1 s"
[[measure]]
kind = "above"
name = "held"
boundary = "shelf"
stage = "hold"
[[measure]]
kind = "above"
name = "left"
boundary = "shelf"
[[measure]]
kind = "above"
name = "lift"
boundary = "lift"
stage = "hold"
[[measure]]
kind = "above"
name = "gone"
boundary = "lift"
[[measure]]
kind = "above"
name = "side"
boundary = "stop"
[output]
frame_interval = "1 ms"
)";

Case shelf(const std::vector<Override>& overrides = {}) {
  return read_case_text(kShelf, "shelf.toml", ".", overrides);
}

TEST(Above, ParticlesCountByTheSideThatBearsThem) {
  const Case c = shelf();
  const BenchRun run = run_case(c);
  const double weight = 9.81 * c.model.shapes[0].mass;
  EXPECT_EQ(run.value("held_above_count"), 2);
  EXPECT_EQ(run.value("held_below_count"), 1);
  // The balls swing on their contacts from zero overlap: each force is up to twice the weight.
  EXPECT_GT(run.value("held_above_force"), 0);
  EXPECT_LT(run.value("held_above_force"), 4.01 * weight);
  // Without the lift, the ball below has fallen.
  EXPECT_EQ(run.value("left_above_count"), 2);
  EXPECT_EQ(run.value("left_below_count"), 0);
  EXPECT_GT(run.value("left_above_force"), 0);
  EXPECT_LT(run.value("left_above_force"), 4.01 * weight);
  // The lift presses the ball against the shelf by more than its weight.
  EXPECT_EQ(run.value("lift_above_count"), 1);
  EXPECT_EQ(run.value("lift_below_count"), 0);
  EXPECT_GT(run.value("lift_above_force"), 10 * weight);
  EXPECT_EQ(run.value("gone_above_count"), 0);
  EXPECT_EQ(run.value("gone_above_force"), 0);
  // The stop pushes a ball sideways: neither up nor down.
  EXPECT_EQ(run.value("side_above_count"), 0);
  EXPECT_EQ(run.value("side_below_count"), 0);
  EXPECT_EQ(run.value("side_above_force"), 0);
  EXPECT_EQ(run["held_above_count"].unit, "1");
  EXPECT_EQ(run["held_above_force"].unit, "N");
  EXPECT_EQ(run["held_below_count"].method,
            "particles pushed down by contacts with \"shelf\" in the last frame of stage \"hold\"");
  ASSERT_EQ(run.measured_again.size(), run.responses.size());
  for (std::size_t i = 0; i < run.responses.size(); ++i)
    if (run.responses[i].name.starts_with("held_")) {
      EXPECT_EQ(run.measured_again[i].value, run.responses[i].value) << run.responses[i].name;
    }
}

// With gravity towards -x, the shelf bears the ball at its side.
TEST(Above, GravitySaysWhatIsUp) {
  const BenchRun run = run_case(shelf({{"case.gravity", "-9.81 0 0 m/s^2"}}));
  EXPECT_EQ(run.value("held_above_count"), 1);
  EXPECT_EQ(run.value("held_below_count"), 0);
  EXPECT_EQ(run.value("side_above_count"), 0);
  EXPECT_EQ(run.value("side_below_count"), 1);
}

// A run that ends before the stage has no such responses.
TEST(Above, AStageThatNeverCameHasNoResponses) {
  const BenchRun run =
      run_case(shelf({{"case.duration", "50 ms"}, {"measure.held.stage", "drop"}}));
  EXPECT_FALSE(run.has("held_above_count"));
  EXPECT_TRUE(run.has("left_above_count"));
}

TEST(Above, IsRefusedInOneLine) {
  const auto complaint = [](const std::string& key, const std::string& value) {
    return test::error_of([&] { shelf({{key, value}}); });
  };
  EXPECT_THAT(complaint("measure.held.boundary", "shell"), HasSubstr("did you mean \"shelf\"?"));
  EXPECT_THAT(complaint("measure.held.stage", "after"), HasSubstr("\"after\" is not a stage"));
  EXPECT_THAT(complaint("measure.held.tag", "0"), HasSubstr("measure.held.tag"));
  EXPECT_THAT(complaint("measure.0", "{ kind = \"above\", boundary = \"shelf\" }"),
              HasSubstr("expected a name"));
  EXPECT_THAT(complaint("case.gravity", "0 0 0 m/s^2"),
              HasSubstr("is \"above\" without gravity; expected a case with one"));
}

}  // namespace
}  // namespace firn
