// Mistakes in a scene.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/experiments/run/harvest_scene.h"

namespace firn {
namespace {

using harvest_scene::kHarvest;
using harvest_scene::scene_error;
using testing::HasSubstr;

TEST(Scene, MistakesAreNamed) {
  const auto set = [](const char* path, const char* value) {
    return scene_error(kHarvest, {{path, value}});
  };
  EXPECT_EQ(scene_error(kHarvest), "");
  EXPECT_THAT(set("boundaries.plate.motion_frame", "plait"),
              HasSubstr("unknown motion frame \"plait\"; did you mean \"plate\"?"));
  EXPECT_THAT(set("motion_frames.plate.parent", "hook"), HasSubstr("unknown motion frame"));
  EXPECT_THAT(set("motion_frames.lift.parent", "plate"), HasSubstr("unknown motion frame"));
  EXPECT_THAT(set("motion_frames.plate.free.joints.0.lower", "1 mm"), HasSubstr("leaves out 0"));
  EXPECT_THAT(set("motion_frames.plate.free.joints.0.lower", "1 deg"), HasSubstr("a length"));
  EXPECT_THAT(set("motion_frames.plate.free.joints.0.bearing_length", "20 mm"),
              HasSubstr("has no use; expected a friction_coefficient"));
  EXPECT_THAT(set("motion_frames.plate.free.joints.0.friction_coefficient", "-0.1"),
              HasSubstr("expected at least 0"));
  EXPECT_EQ(set("motion_frames.plate.free.joints.0.friction_coefficient", "0.1"), "");
  EXPECT_THAT(
      scene_error(kHarvest, {{"motion_frames.plate.free.joints.0.friction_coefficient", "0.1"},
                             {"motion_frames.plate.free.joints.0.bearing_radius", "3 mm"}}),
      HasSubstr("expected a joint of the kind \"rotation\""));
  EXPECT_THAT(set("motion_frames.plate.free.density", "1 kg/m^3"),
              HasSubstr("expected one of mass and density"));
  EXPECT_THAT(set("stages.harvest.switch", "empty"), HasSubstr("unknown switch"));
  EXPECT_THAT(set("stages.harvest.until", "later"), HasSubstr("expected one of time, settled"));
  EXPECT_THAT(set("stages.harvest.gate", "below"),
              HasSubstr("without end_when = \"passed\"; expected both"));
  EXPECT_THAT(set("stages.drop.mass", "1 kg"), HasSubstr("one of count and mass"));
  EXPECT_THAT(set("stages.harvest.motors.0.motion_frame", "lift"), HasSubstr("has no joint 0"));
  EXPECT_THAT(set("stages.harvest.motors.0.every", "0.1 s"), HasSubstr("shorter than what is"));
  EXPECT_THAT(set("sources.mold.stage", "harvst"), HasSubstr("did you mean \"harvest\"?"));
  EXPECT_THAT(set("sources.mold.interval", "0 s"), HasSubstr("expected the time between them"));
  EXPECT_THAT(set("tags.0.stage", "dropp"), HasSubstr("unknown stage"));
  EXPECT_THAT(set("switches.full.motion_frame", "lift"), HasSubstr("expected one of a free body"));
  EXPECT_THAT(set("gates.below.region_min", "0 0 0 m"), HasSubstr("either region_min"));
  // A prescribed motion on a free frame.
  EXPECT_THAT(set("boundaries.plate.motions",
                  "[{ kind = \"vibration\", direction = [0, 0, 1], amplitude = \"1 mm\", "
                  "frequency = \"50 Hz\" }]"),
              "");
  const std::string motion = "motion_frames.lift.motions";
  EXPECT_THAT(set(motion.c_str(),
                  "[{ kind = \"translation_table\", direction = [0, 0, 1], times = "
                  "[\"0 s\", \"1 s\", \"0.5 s\"], positions = [\"0 m\", \"0 m\", \"0 m\"] }]"),
              HasSubstr("each later than the one before"));
  EXPECT_THAT(set(motion.c_str(),
                  "[{ kind = \"translation_table\", direction = [0, 0, 1], times = "
                  "[\"0 s\", \"1 ms\"], positions = [\"0 m\", \"1 m\"] }]"),
              HasSubstr("jump from 0 to 1 m"));
}

}  // namespace
}  // namespace firn
