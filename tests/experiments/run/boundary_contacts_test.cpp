// [[boundary_contacts]] of a case, from the file to responses, and parts that run into each other
// without one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "experiments/case_reader/read_case.h"
#include "experiments/responses/load_responses.h"
#include "experiments/results/results_file.h"
#include "experiments/run/run.h"
#include "tests/support/error_of.h"
#include "tests/support/replaced.h"
#include "tests/support/results_folder.h"

namespace firn {
namespace {

using testing::HasSubstr;

// A slide of 0.5 kg that a motor pushes with 5 N against a post.
constexpr const char* kPress = R"(
[case]
duration = "0.4 s"
gravity = "0 0 0 m/s^2"
[materials.steel]
density = "7800 kg/m^3"
young_modulus = "10 MPa"
[interactions.steel-steel]
static_friction = 0.1
restitution = 0.3
[shapes.cube]
kind = "box"
size = "20 20 20 mm"
material = "steel"
[[particles]]
shape = "cube"
position = "0 0 500 mm"
[[motion_frames]]
name = "slide"
[motion_frames.free]
mass = "0.5 kg"
center = "0 0 0 m"
inertia = "1e-3 1e-3 1e-3 kg m^2"
[[motion_frames.free.joints]]
kind = "translation"
direction = [1, 0, 0]
damping = "100 N s/m"
drives = [{ speed = "1 m/s", max_load = "5 N" }]
[[boundaries]]
name = "ram"
kind = "box"
material = "steel"
size = "20 20 20 mm"
position = "0 0 0 mm"
motion_frame = "slide"
[[boundaries]]
name = "post"
kind = "box"
material = "steel"
size = "20 40 40 mm"
position = "22 0 0 mm"
)";

constexpr const char* kContact = R"(
[[boundary_contacts]]
between = ["ram", "post"]
stiffness = "1e5 N/m"
static_friction = 0.2
restitution = 0.5
[[measure]]
kind = "load"
name = "press"
boundary_contact = "ram-post"
direction = [-1, 0, 0]
[[measure]]
kind = "curve"
name = "press"
boundary_contact = "ram-post"
y = "peak_normal_force"
points = 10
)";

std::string error_of(const std::string& text) {
  return test::error_if_any([&] { read_case_text(text, "c.toml", "."); });
}

using test::replaced;

using BoundaryContactCase = ResultsFolder;

TEST_F(BoundaryContactCase, PressAgainstEachOther) {
  const Case c = read_case_text(std::string(kPress) + kContact, "c.toml", ".");
  RunOptions options;
  options.results_file = path("press.h5");
  EXPECT_EQ(run(c, options).status, RunStatus::finished);
  const Recording recording(path("press.h5"));
  const std::vector<double> force = recording.series("/boundary_contacts/ram-post/force");
  ASSERT_GE(force.size(), 6u);
  EXPECT_NEAR(force[force.size() - 3], -5, 1e-3);  // on the ram, in the end
  // Pushed by the motor, held by the post: nothing is left along the axis but the motor's own
  // force.
  const std::vector<double> joint = recording.series("/motion_frames/slide/reaction_force");
  EXPECT_NEAR(joint[joint.size() - 3], 5, 1e-3);
  const auto loads = load_responses(recording, c);
  ASSERT_EQ(loads.size(), 2u);
  EXPECT_EQ(loads[0].name, "press_load_mean");
  EXPECT_GT(loads[1].value[0], 4.9);
}

TEST_F(BoundaryContactCase, StopsWithPlaceAndTimeWherePartsRunIntoEachOtherWithoutOne) {
  const Case c = read_case_text(kPress, "c.toml", ".");
  RunOptions options;
  options.results_file = path("crash.h5");
  const RunSummary summary = run(c, options);
  EXPECT_EQ(summary.status, RunStatus::failed);
  EXPECT_THAT(summary.reason, HasSubstr("\"ram\" and \"post\" have run into each other at 0.0"));
  EXPECT_THAT(summary.reason, HasSubstr("near (1"));
}

TEST_F(BoundaryContactCase, MayPassWhereThatIsAllowed) {
  const Case c = read_case_text(replaced(kPress, "position = \"22 0 0 mm\"",
                                         "position = \"22 0 0 mm\"\nmay_touch = [\"ram\"]"),
                                "c.toml", ".");
  RunOptions options;
  options.results_file = path("pass.h5");
  EXPECT_EQ(run(c, options).status, RunStatus::finished);
}

TEST(BoundaryContactReader, RefusesWhatIsNoContactInOneLine) {
  const auto with = [](const std::string& from, const std::string& to) {
    return error_of(std::string(kPress) + replaced(kContact, from, to));
  };
  EXPECT_EQ(error_of(std::string(kPress) + kContact), "");
  EXPECT_THAT(with("\"post\"]", "\"past\"]"), HasSubstr("unknown boundary \"past\""));
  EXPECT_THAT(with("\"post\"]", "\"ram\"]"), HasSubstr("does not name two boundaries"));
  EXPECT_THAT(with("stiffness = \"1e5 N/m\"\n", ""), HasSubstr("stiffness"));
  EXPECT_THAT(with("stiffness = \"1e5 N/m\"", "stiffness = \"-1 N/m\""), HasSubstr("stiffness"));
  EXPECT_THAT(with("restitution = 0.5", "restitution = 1.5"), HasSubstr("restitution"));
  EXPECT_THAT(with("restitution = 0.5", "restitution = 0.5\nrolling_resistance = 0.1"),
              HasSubstr("rolling_resistance"));
  EXPECT_THAT(with("boundary_contact = \"ram-post\"", "boundary_contact = \"ram-pest\""),
              HasSubstr("unknown boundary contact"));
  EXPECT_THAT(with("[[measure]]", std::string(kContact) + "[[measure]]"), HasSubstr("c.toml:"));
  EXPECT_THAT(error_of(replaced(std::string(kPress) + kContact, "motion_frame = \"slide\"", "")),
              HasSubstr("no force can move"));
}

TEST(BoundaryContactReader, RefusesAMotorWhoseCharacteristicIsNone) {
  const auto with = [](const std::string& drive) {
    return error_of(
        replaced(kPress, "{ speed = \"1 m/s\", max_load = \"5 N\" }", "{ " + drive + " }"));
  };
  EXPECT_EQ(with("speed = \"1 m/s\", max_load = \"5 N\", no_load_speed = \"2 m/s\""), "");
  EXPECT_THAT(with("speed = \"1 m/s\", no_load_speed = \"2 m/s\""), HasSubstr("stall"));
  EXPECT_THAT(with("speed = \"3 m/s\", max_load = \"5 N\", no_load_speed = \"2 m/s\""),
              HasSubstr("no_load_speed"));
  EXPECT_THAT(with("speed = \"1 m/s\", max_load = \"5 N\", no_load_speed = \"0 m/s\""),
              HasSubstr("no_load_speed"));
}

}  // namespace
}  // namespace firn
