// The setup file of a photograph: what is read, and one line for every mistake.
#include "photo/photo_setup.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/error_of.h"
#include "tests/support/replaced.h"

namespace firn {
namespace {

using testing::HasSubstr;

const std::string kSetup = R"(name = "drained heap"
particle_size = "20.6 mm"
height = "250 mm"
depth = "140 mm"
camera_distance = "2 m"
corners = [
  { pixel = [180, 905], x = "-298.5 mm", z = "0 mm" },
  { pixel = [1420, 880], x = "298.5 mm", z = "0 mm" },
  { pixel = [1425.5, 360], x = "298.5 mm", z = "250 mm" },
  { pixel = [175, 372], x = "-298.5 mm", z = "250 mm" },
]
pixel_uncertainty = 3

[camera]
focal_length = 1900
k1 = -0.08

[segmentation]
channel = "blue"
heap = "darker"
background = "empty.jpg"

[[slopes]]
name = "left"
begin = "-73 mm"
end = "-298.5 mm"

[[slopes]]
name = "right"
begin = "73 mm"
end = "298.5 mm"
end_margin = "40 mm"
)";

using test::replaced;

std::string refusal(const std::string& text) {
  return test::error_of([&] { read_photo_setup_text(text, "photos/setup.toml"); });
}

TEST(PhotoSetup, EveryKeyIsRead) {
  const PhotoSetup s = read_photo_setup_text(kSetup, "photos/setup.toml");
  EXPECT_EQ(s.name, "drained heap");
  EXPECT_EQ(s.response, "angle_of_repose_outline");
  EXPECT_DOUBLE_EQ(s.particle_size, 20.6e-3);
  EXPECT_DOUBLE_EQ(s.height, 0.25);
  EXPECT_DOUBLE_EQ(s.depth, 0.14);
  EXPECT_DOUBLE_EQ(s.camera_distance, 2);
  ASSERT_EQ(s.corners.size(), 4U);
  EXPECT_EQ(s.corners[2].pixel, Vec2(1425.5, 360));
  EXPECT_EQ(s.corners[2].wall, Vec2(0.2985, 0.25));
  EXPECT_EQ(s.pixel_uncertainty, 3);
  EXPECT_DOUBLE_EQ(s.position_uncertainty, 0.5e-3);
  EXPECT_NEAR(s.level_uncertainty * kRadToDeg, 0.3, 1e-12);
  EXPECT_EQ(s.focal_length, 1900);
  EXPECT_EQ(s.k1, -0.08);
  EXPECT_EQ(s.channel, PhotoChannel::blue);
  EXPECT_FALSE(s.heap_is_brighter);
  EXPECT_EQ(s.background, "photos/empty.jpg");
  ASSERT_EQ(s.ledges.size(), 2U);
  EXPECT_NEAR(s.ledges[0].length(), 0.2255, 1e-12);
  EXPECT_NEAR(s.ledges[0].x(0.1), -0.173, 1e-12);
  EXPECT_NEAR(s.ledges[1].x(0.1), 0.173, 1e-12);
  EXPECT_NEAR(s.ledges[1].window.to, 0.1855, 1e-12);
  const Lens lens = s.lens(1600, 1200);
  EXPECT_EQ(lens.principal_point, Vec2(800, 600));
  EXPECT_EQ(lens.focal_length, 1900);
}

TEST(PhotoSetup, MistakesAreOneLineWithThePlace) {
  const struct {
    const char *from, *to, *message;
  } mistakes[] = {
      {"name = \"drained heap\"", "name = \"\"", "setup.toml:1: name: is empty"},
      {"particle_size = \"20.6 mm\"", "particle_size = \"0 mm\"", "setup.toml:2: particle_size: "},
      {"particle_size = \"20.6 mm\"", "particel_size = \"2 mm\"",
       "did you mean \"particle_size\"?"},
      {"height = \"250 mm\"", "height = \"250 m\"", "setup.toml:3: height: is more than 1000"},
      {"pixel = [180, 905]", "pixel = [180]", "setup.toml:7: corners.0.pixel: has 1 entries"},
      {"pixel = [180, 905]", "pixel = [1420, 880]", "corners: "},
      {"pixel = [180, 905]", "pixel = [1800, 905]",
       "corners: are not in the order of their places"},
      {"pixel = [180, 905]", "pixel = [1e9, 905]", "pixel: is too large"},
      {"pixel_uncertainty = 3", "pixel_uncertainty = -1",
       "setup.toml:12: pixel_uncertainty: is -1"},
      {"k1 = -0.08", "k1 = -2", "camera.k1: is -2; expected -1 to 1"},
      {"focal_length = 1900\n", "", "camera.k1: goes with a focal length"},
      {"channel = \"blue\"", "channel = \"infrared\"", "segmentation.channel: "},
      {"name = \"right\"", "name = \"left\"", "is that of another slope"},
      {"end_margin = \"40 mm\"", "end_margin = \"170 mm\"", "expected smaller margins"},
      {"camera_distance = \"2 m\"", "camera_distance = \"1.5 m\"",
       "slopes.left.end_margin: is too small: from 1.5 m, ice at the back wall appears 0.0255 m "
       "nearer"},
      {"end = \"-298.5 mm\"", "end = \"-298.5 m\"", "more than 1000 particle sizes"},
  };
  for (const auto& m : mistakes) {
    const std::string message = refusal(replaced(kSetup, m.from, m.to));
    EXPECT_THAT(message, HasSubstr(m.message)) << m.to;
    EXPECT_THAT(message, HasSubstr("photos/setup.toml:")) << m.to;
    EXPECT_EQ(message.find('\n'), std::string::npos);
  }
  EXPECT_THAT(refusal(kSetup.substr(0, kSetup.find("[[slopes]]"))),
              HasSubstr("slopes: is missing"));
}

TEST(PhotoSetup, ALensThatFoldsThePictureIsRefused) {
  const PhotoSetup s = read_photo_setup_text(replaced(kSetup, "k1 = -0.08", "k1 = -0.9"), "s.toml");
  EXPECT_THROW(s.lens(1600, 1200), InputError);
}

}  // namespace
}  // namespace firn
